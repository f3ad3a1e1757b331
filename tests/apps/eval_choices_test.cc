// `engram eval --policy-choices`: policies in processes that name answers.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

std::string chooser(const std::string& options = "") {
  return "--policy-choices '" + choices_policy() + options + "' ";
}

// What goes behind a Python that may start later than it is waited for: it would complain of its
// closed pipe.
const std::string kSilent = " 2>/dev/null";

// The example with another function that answers.
std::string answering(const std::string& expression, const std::string& behind = "") {
  return "--policy-choices 'python3 -c \"import sys; sys.argv[1:] = []; sys.path.insert(0, \\\"" +
         (std::filesystem::path(test::kRoot) / "python" / "examples").string() +
         "\\\"); import choices_policy; choices_policy.answer = lambda asked, notes: " +
         expression + "; choices_policy.main()\"" + behind + "' ";
}

ParsedJson evaluate(const std::string& arguments) {
  return engram_command("eval --json --obs objects " + arguments).json();
}

TEST_CASE("eval: plain rules over the objects in words solve tasks without images", "[apps]") {
  const ParsedJson results = evaluate(
      "RememberColor9-VLA-v0 RememberShape5-VLA-v0 FindImposterColor5-VLA-v0 ShellGameTouch-VLA-v0 "
      "ShellGameShuffleTouch-VLA-v0 ShellGameColorLampTouch-VLA-v0 TakeItBack-VLA-v0 "
      "BlinkCountButtonPressEasy-VLA-v0 ChainOfColors3-VLA-v0 GatherAndRecall1-VLA-v0 "
      "BatteriesCheckerEasy-3-VLA-v0 TraceShapeHard-VLA-v0 "
      "TraceShapeSeqHard-VLA-v0 --episodes 10 " +
      chooser());
  REQUIRE(results["tasks"].size() == 13);
  for (const ParsedJson& task : results["tasks"]) {
    INFO(task["env_id"]);
    CHECK(task["sr"].get<double>() >= 0.9);
    CHECK(task["choices"] == true);
    CHECK_FALSE(task.contains("choices_stride"));
    CHECK(task["memory_score"].is_null());
    CHECK(task["action_chunk_size"] == 1);
    CHECK(task["obs_mode"] == "objects");
    CHECK(task["model"]["name"] == "external");
  }
}

TEST_CASE("eval: the example that guesses is at chance, without any observation", "[apps]") {
  const ParsedJson task =
      engram_command("eval --json --obs state RememberColor3-VLA-v0 --episodes 100 " +
                     chooser(" --guess") + "--policy-name guess --choices-stride 100")
          .json()["tasks"][0];
  CHECK(std::abs(task["sr"].get<double>() - task["chance"].get<double>()) < 0.19);  // 4 sigma
  CHECK(task["sr"] == task["first_answer_correct"]);
  CHECK(task["model"]["name"] == "guess");
  CHECK(task["choices_stride"] == 100);
}

TEST_CASE("eval: choices are the same for any threads, batches and rounds", "[apps]") {
  const std::string guess =
      "RememberColor3-VLA-v0 BatteriesCheckerEasy-3-VLA-v0 --episodes 4 " + chooser(" --guess");
  const ParsedJson expected = evaluate(guess + "--num-envs 4 --threads 1");
  CHECK(evaluate(guess + "--num-envs 1 --threads 2") == expected);
  CHECK(evaluate(guess + "--num-envs 3 --threads 3") == expected);
  const ParsedJson rounds = evaluate(guess + "--repeat 2 --policy-seed 0");
  const ParsedJson& digests = rounds["tasks"][0]["digests"];
  CHECK(digests["first_observations"][0] == digests["first_observations"][4]);
  CHECK(digests["answers"] != expected["tasks"][0]["digests"]["answers"]);
}

TEST_CASE("eval: images are frames, too", "[apps]") {
  const ParsedJson task =
      engram_command("eval --json RememberColor3-VLA-v0 --episodes 2 " +
                     answering("asked[\\\"choices\\\"][:1] if asked[\\\"rgb\\\"].shape == "
                               "(len(asked[\\\"steps\\\"]), 128, 128, 6) else []"))
          .json()["tasks"][0];
  CHECK(task["obs_mode"] == "rgb");
}

TEST_CASE("eval: answers of another form end the run with a sentence", "[apps]") {
  const std::string eval = "eval --obs objects --episodes 1 --threads 1 RememberColor3-VLA-v0 ";
  const std::pair<const char*, const char*> answers[] = {
      {"[\\\"the pink cube\\\"]", "choice 'the pink cube' given, the "},
      {"[\\\"7\\\"]", "choice 7 given, 0 to 2 allowed"},
      {"[]", "0 choices given, 1 needed"},
      {"[\\\"0\\\", \\\"1\\\"]", "2 choices given, at most 1 allowed"},
      {"sys.exit(3)", "ended with exit code 3"}};
  for (const auto& [expression, words] : answers) {
    require_refusal(eval + answering(expression), 1, words);
  }
  require_refusal(eval + answering("[\\\"7\\\"]"), 1, "of episode 0 of RememberColor3-VLA-v0");
  require_refusal(
      eval + answering("__import__(\\\"time\\\").sleep(9)", kSilent) + "--policy-timeout 1", 1,
      "has not answered within 1 s");
  // A policy that sends actions does not know questions.
  require_refusal(eval + "--policy-choices '" + pipe_policy() + kSilent + "' --policy-timeout 2", 1,
                  "has not answered within 2 s");
}

TEST_CASE("eval: what goes with choices, and what does not", "[apps]") {
  const std::string eval = "eval RememberColor3-VLA-v0 ";
  require_refusal("eval TimedTransferEasy-VLA-v0 " + chooser(), 2,
                  "TimedTransferEasy-VLA-v0 has no list of answers to choose from");
  require_refusal(eval + chooser() + "--latency 2", 2, "a latency of 2 steps given");
  require_refusal(eval + chooser() + "--control-mode pd_ee_delta_pos", 2,
                  "pd_ee_delta_pose, pd_joint_pos or pd_joint_delta_pos needed");
  require_refusal(eval + chooser() + "--policy oracle", 2, "--policy excludes --policy-choices");
  require_refusal(eval + "--choices-stride 2", 2, "--choices-stride requires --policy-choices");
  require_refusal(eval + chooser() + "--choices-stride 0", 2, "--choices-stride: '0' given");
  require_refusal(eval + chooser() + "--policy-name oracle", 2, "--policy-name: 'oracle' given");
}

TEST_CASE("eval: a folder belongs to choices or to actions", "[apps]") {
  const TemporaryFolder folder;
  const std::string eval = "RememberColor3-VLA-v0 --obs objects --episodes 2 ";
  REQUIRE(engram_command("eval " + eval + chooser() + "--choices-stride 2 --out " +
                         folder.path().string())
              .code == 0);
  const auto run = std::filesystem::directory_iterator(folder.path() / "short")->path().string();
  const ParsedJson settings =
      ParsedJson::parse(read_file(std::filesystem::path(run) / "settings.json"));
  CHECK(settings["choices"] == true);
  CHECK(settings["choices_stride"] == 2);
  const std::string resume = "eval --resume " + run + " ";
  require_refusal(resume, 2, "the same --policy-choices needed");
  const std::string words = chooser();
  require_refusal(resume + "--policy-command" + words.substr(words.find(' ')), 2,
                  "has results of choices true; false given now");
  require_refusal(resume + chooser(" --guess"), 2, "has results of policy_config");
  require_refusal(resume + chooser() + "--choices-stride 3", 2,
                  "has results of choices_stride 2; 3 given now");
  const ParsedJson again = engram_command(resume + chooser() + "--json").json();
  CHECK(again["tasks"][0]["choices_stride"] == 2);
}

TEST_CASE("eval: a sealed run of choices tells nobody its seeds before the end", "[apps]") {
  const TemporaryFolder folder;
  const std::string secret = (folder.path() / "seed").string();
  std::ofstream(secret) << std::string(64, 'a') << '\n';
  const std::string eval =
      "RememberColor3-VLA-v0 --episodes 3 " + chooser() + "--seed-file " + secret;
  const ParsedJson closed = evaluate(eval + " --keep-sealed")["tasks"][0];
  CHECK(closed["episode_seeds"].is_null());
  CHECK(closed["choices"] == true);
  const ParsedJson revealed = evaluate(eval)["tasks"][0];
  CHECK(revealed["successes"] == closed["successes"]);
  const std::string seed = revealed["start_seed"].dump();
  CHECK(evaluate("RememberColor3-VLA-v0 --episodes 3 " + chooser() + "--seed " +
                 seed)["tasks"][0]["digests"]["first_observations"] ==
        revealed["digests"]["first_observations"]);
}

TEST_CASE("compare: choices and actions are told apart", "[apps]") {
  const TemporaryFolder folder;
  const auto evaluated = [&folder](const std::string& name, const std::string& options) {
    std::string path = (folder.path() / name).string();
    std::ofstream(path) << evaluate("RememberColor3-VLA-v0 --episodes 5 " + options).dump();
    return path;
  };
  const std::string named = evaluated("named", chooser());
  const std::string guessed = evaluated("guessed", chooser(" --guess"));
  const std::string acted = evaluated("acted", "--policy blind");
  CHECK(engram_command("compare " + named + " " + guessed + " --json").json()["total"]["pairs"] ==
        5);
  require_refusal("compare " + named + " " + acted, 2,
                  "allow choices to compare them nevertheless");
  CHECK(engram_command("compare " + named + " " + acted + " --allow choices").code == 0);
}

TEST_CASE("report: choices are named as such, and are no entry of a leaderboard", "[apps]") {
  const TemporaryFolder folder;
  REQUIRE(engram_command("eval RememberColor3-VLA-v0 --obs objects --episodes 2 " + chooser() +
                         "--out " + folder.path().string())
              .code == 0);
  const auto run = std::filesystem::directory_iterator(folder.path() / "short")->path();
  CHECK_THAT(read_file(run / "report.html"),
             Catch::Contains("names answers; a scripted hand acts"));
  CHECK(engram_command("report " + run.string()).code == 0);
  require_refusal("report " + run.string() + " --format vla-eval", 2,
                  "results of choices given, of actions needed");
}

TEST_CASE("record: films what a named answer looks like", "[apps]") {
  const TemporaryFolder folder;
  const auto film = [&folder](const std::string& options) {
    const std::string out = (folder.path() / "film.gif").string();
    return engram_command("record --seed 4242424242 --size 64 --json --out " + out + " " + options)
        .json();
  };
  const ParsedJson named = film("RememberColor3-VLA-v0 --obs objects " + chooser());
  CHECK(named["success_once"] == true);
  CHECK(named["choices"] == true);
  CHECK_FALSE(film("RememberColor3-VLA-v0 --policy oracle").contains("choices"));
  require_refusal("record InterceptSlow-VLA-v0 --out x.gif " + chooser(), 2,
                  "InterceptSlow-VLA-v0 has no list of answers");
}

TEST_CASE("eval: chance is that of a choice, and of a first answer where a wrong one fails",
          "[apps]") {
  const std::string eval = "TraceShapeHard-VLA-v0 --episodes 2 " + chooser(" --guess");
  const ParsedJson about = engram_command("info TraceShapeHard-VLA-v0 --json").json();
  CHECK(evaluate(eval)["tasks"][0]["chance"] == about["choices"]["chance"]);
  CHECK(about["choices"]["chance"] != about["chance"]);
  CHECK(evaluate(eval + "--option strict=1")["tasks"][0]["chance"] == about["answer_chance"]);
}

TEST_CASE("info: the choices of a task", "[apps]") {
  const ParsedJson choices = engram_command("info ChainOfColors5-VLA-v0 --json").json()["choices"];
  CHECK(keys_of(choices) == std::vector<std::string>{"question", "choices", "least", "most",
                                                     "repeats", "questions", "chance"});
  CHECK(choices["choices"].size() == 9);
  CHECK(choices["least"] == 5);
  CHECK(choices["most"] == 5);
  CHECK(choices["repeats"] == false);
  CHECK(engram_command("info TimedTransferEasy-VLA-v0 --json").json()["choices"].is_null());
}

}  // namespace
}  // namespace engram::test
