// `engram eval --repeat --policy-seed --latency`.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/apps/command.h"
#include "tests/build_paths.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

ParsedJson evaluate(const std::string& options) {
  return engram_command(std::string("eval ") + kId + " --json --episodes 6 " + options)
      .json()["tasks"][0];
}

// The elements `first` to `last` - 1 of a list.
ParsedJson slice(const ParsedJson& all, std::ptrdiff_t first, std::ptrdiff_t last) {
  return {all.begin() + first, all.begin() + last};
}

// A policy that moves by its seed.
std::string seeded_policy() {
  const auto examples = std::filesystem::path(test::kRoot) / "python" / "examples";
  return "python3 -c \"import sys; sys.path.insert(0, \\\"" + examples.string() +
         "\\\"); import pipe_policy; "
         "pipe_policy.act = lambda task, asked: [((1, 7), [asked[\\\"policy_seed\\\"] / 10] + [0] "
         "* "
         "6)] * asked[\\\"count\\\"]; pipe_policy.main()\"";
}

}  // namespace

TEST_CASE("eval: rounds of the same episodes have policy seeds of their own", "[apps]") {
  const ParsedJson rounds = evaluate("--policy random --repeat 2 --policy-seed 3");
  CHECK(rounds["n_episodes"] == 12);
  CHECK(rounds["repeat"] == 2);
  CHECK(rounds["policy_seed"] == 3);
  CHECK(rounds["returns"].size() == 12);
  CHECK(slice(rounds["episode_seeds"], 6, 12) == slice(rounds["episode_seeds"], 0, 6));
  const ParsedJson first = evaluate("--policy random --policy-seed 3");
  const ParsedJson second = evaluate("--policy random --policy-seed 4");
  CHECK(slice(rounds["returns"], 0, 6) == first["returns"]);
  CHECK(slice(rounds["returns"], 6, 12) == second["returns"]);
  CHECK(first["returns"] != second["returns"]);
  // What an episode begins with is no policy's.
  CHECK(first["digests"]["first_observations"] == second["digests"]["first_observations"]);
  CHECK(first["digests"]["first_answers"] != second["digests"]["first_answers"]);
  const ParsedJson usual = evaluate("--policy random");
  CHECK_FALSE(usual.contains("policy_seed"));
  CHECK(evaluate("--policy random --policy-seed 0 --repeat 1") == usual);
  CHECK(usual["returns"] != first["returns"]);
}

TEST_CASE("eval: rounds and latency are the same for any threads and batches", "[apps]") {
  for (const char* policy : {"random", "blind"}) {
    const std::string options =
        std::string("--repeat 3 --latency 2 --policy-seed 9 --policy ") + policy;
    const ParsedJson expected = evaluate(options + " --num-envs 6 --threads 1");
    CHECK(evaluate(options + " --num-envs 1 --threads 2") == expected);
    CHECK(evaluate(options + " --num-envs 4 --threads 3") == expected);
  }
}

TEST_CASE("eval: external policies are told their seed, and act late", "[apps]") {
  const std::string command = "--obs state --policy-command '" + seeded_policy() + "' ";
  const ParsedJson rounds =
      evaluate(command + "--repeat 2 --policy-seed 1 --num-envs 2 --threads 2");
  CHECK(slice(rounds["returns"], 0, 6) != slice(rounds["returns"], 6, 12));
  CHECK(evaluate(command + "--policy-seed 2")["returns"] == slice(rounds["returns"], 6, 12));
  CHECK(rounds["digests"]["first_answers"][0] == rounds["digests"]["first_answers"][1]);
  const ParsedJson late = evaluate(command + "--policy-seed 1 --latency 4");
  CHECK(late["returns"] != slice(rounds["returns"], 0, 6));
}

TEST_CASE("eval: latency in steps and milliseconds", "[apps]") {
  const ParsedJson prompt = evaluate("--policy oracle");
  CHECK_FALSE(prompt.contains("latency_steps"));
  CHECK(evaluate("--policy oracle --latency 0") == prompt);
  const ParsedJson late = evaluate("--policy oracle --latency 3");
  CHECK(late["latency_steps"] == 3);
  CHECK(late["returns"] != prompt["returns"]);
  CHECK(late["digests"]["first_observations"] == prompt["digests"]["first_observations"]);
  CHECK(evaluate("--policy oracle --latency 120ms") == late);
  // An answer after the end of the episode: nothing is ever commanded.
  const ParsedJson never = evaluate("--policy oracle --latency 25");
  CHECK(evaluate("--policy random --latency 25")["returns"] == never["returns"]);
  CHECK(never["sr"] == 0.0);
  const std::string eval = std::string("eval ") + kId + " ";
  require_refusal(eval + "--latency soon", 2, "--latency: 'soon' given, 0 to 1000000");
  require_refusal(eval + "--repeat 0", 2,
                  "--repeat: '0' given, a whole number of 1 to 1000 allowed");
  require_refusal(eval + "--policy-seed -1", 2, "--policy-seed: '-1' given");
}

TEST_CASE("eval: a folder belongs to one latency, repeat and policy seed", "[apps]") {
  const TemporaryFolder folder;
  const std::string eval =
      std::string("eval ") + kId + " --policy random --episodes 2 --repeat 2 --latency 1 ";
  REQUIRE(engram_command(eval + "--policy-seed 5 --out " + folder.path().string()).code == 0);
  const auto run = std::filesystem::directory_iterator(folder.path() / "short")->path().string();
  const ParsedJson settings =
      ParsedJson::parse(read_file(std::filesystem::path(run) / "settings.json"));
  CHECK(settings["latency_steps"] == 1);
  CHECK(settings["repeat"] == 2);
  CHECK(settings["policy_seed"] == 5);
  const std::string resume = "eval --resume " + run + " --json";
  CHECK(engram_command(resume).json()["tasks"][0]["n_episodes"] == 4);
  CHECK(engram_command(resume + " --latency 50ms --repeat 2 --policy-seed 5").code == 0);
  require_refusal(resume + " --latency 2", 2, "has results of latency_steps 1; 2 given now");
  require_refusal(resume + " --repeat 3", 2, "has results of repeat 2; 3 given now");
  require_refusal(resume + " --policy-seed 0", 2, "has results of policy_seed 5; 0 given now");
  // A line for each episode.
  const std::string episodes = read_file(std::filesystem::path(run) / "episodes.csv");
  CHECK(std::count(episodes.begin(), episodes.end(), '\n') == 5);
}

TEST_CASE("record: with latency, as in an evaluation", "[apps]") {
  const TemporaryFolder folder;
  const auto film = [&](const std::string& options) {
    const std::string out = (folder.path() / "film.gif").string();
    const CommandResult result =
        engram_command("record RememberColor3-VLA-v0 --seed 4242424242 --size 64 --json --out " +
                       out + " " + options);
    INFO(result.err);
    REQUIRE(result.code == 0);
    return read_file(out);
  };
  const std::string prompt = film("--policy oracle");
  CHECK(film("--policy oracle --latency 0") == prompt);
  CHECK(film("--policy oracle --latency 2") != prompt);
  CHECK(film("--policy random --policy-seed 1") != film("--policy random"));
  CHECK(film("--policy zero --latency 25") == film("--policy random --latency 25"));
}

}  // namespace engram::test
