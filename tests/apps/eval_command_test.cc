// `engram eval`: the protocol, its files, and independence of threads and batches.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "tests/apps/command.h"
#include "tests/build_paths.h"
#include "tests/sanitizers.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

std::string evaluation(const std::string& options) {
  return std::string("eval ") + kId + " --json " + options;
}

// Every file of a folder whose bytes the protocol fixes, by name.
std::map<std::string, std::string> results_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.path().extension() == ".json" && name != "timing.json") {
      files[name] = read_file(entry.path());
    }
  }
  return files;
}

std::filesystem::path only_entry(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> entries;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    entries.push_back(entry.path());
  }
  REQUIRE(entries.size() == 1);
  return entries[0];
}

// A run whose results are known, and are cheap to get.
struct Run {
  TemporaryFolder folder;
  std::filesystem::path path;
  std::string command =
      "eval RememberColor3-VLA-v0 RememberColor5-VLA-v0 TakeItBack-VLA-v0 --policy oracle "
      "--episodes 4 ";

  Run() {
    const CommandResult result = engram_command(command + "--out " + folder.path().string());
    INFO(result.err);
    REQUIRE(result.code == 0);
    path = only_entry(folder.path() / "short");
  }
  std::string resume() const { return "eval --resume " + path.string(); }
};

std::string python_policy(const std::string& command) {
  return evaluation("--episodes 3 --num-envs 2 --threads 1 --policy-timeout 20 --policy-command " +
                    ("'" + command + "'"));
}

const std::string kPipePolicy = pipe_policy();

}  // namespace

TEST_CASE("eval: documents of the protocol", "[apps]") {
  const ParsedJson document = engram_command(evaluation("--episodes 5")).json();
  CHECK(keys_of(document) == std::vector<std::string>{"summary", "tasks"});
  CHECK(keys_of(document["summary"]) ==
        std::vector<std::string>{"split", "sr_split", "sr_per_memory_type", "tasks", "per_task_sr",
                                 "per_task_mean_return", "sr_interval", "splits",
                                 "per_task_sr_interval"});
  REQUIRE(document["tasks"].size() == 1);
  const ParsedJson& task = document["tasks"][0];
  CHECK(keys_of(task) == std::vector<std::string>{// The protocol's, then engram's own.
                                                  "env_id",
                                                  "split",
                                                  "memory_type",
                                                  "start_seed",
                                                  "n_episodes",
                                                  "successes",
                                                  "returns",
                                                  "sr",
                                                  "mean_return",
                                                  "benchmark_commit",
                                                  "control_mode",
                                                  "obs_mode",
                                                  "wrapper_chain",
                                                  "action_chunk_size",
                                                  "model",
                                                  "episode_lengths",
                                                  "episode_seeds",
                                                  "version",
                                                  "rules",
                                                  "chance",
                                                  "first_answers",
                                                  "first_answers_correct",
                                                  "first_answer_correct",
                                                  "answer_chance",
                                                  "memory_score",
                                                  "subtasks_done",
                                                  "subtasks",
                                                  "completion_rate",
                                                  "sr_interval",
                                                  "digests",
                                                  "checksum"});
  CHECK(task["split"] == "Short");
  CHECK(task["memory_type"] == "Object");
  CHECK(task["start_seed"] == 4242424242);
  CHECK(task["successes"] == std::vector<bool>(5, true));
  CHECK(task["episode_lengths"] == std::vector<int>(5, 25));
  CHECK(task["episode_seeds"][4] == 4242424246);
  CHECK(task["chance"].get<double>() == Approx(1.0 / 3));
  CHECK(task["model"]["name"] == "oracle");
  CHECK(task["rules"] == "reference");
  CHECK(document["summary"]["sr_per_memory_type"]["Object"] == 1.0);
}

TEST_CASE("eval: the oracle remembers, the blind one guesses", "[apps]") {
  const ParsedJson oracle = engram_command(evaluation("--policy oracle")).json();
  CHECK(oracle["tasks"][0]["n_episodes"] == 50);
  CHECK(oracle["tasks"][0]["sr"].get<double>() >= 0.95);
  const ParsedJson blind = engram_command(evaluation("--policy blind --episodes 300")).json();
  // Four standard deviations of 300 guesses.
  CHECK(blind["tasks"][0]["sr"].get<double>() == Approx(1.0 / 3).margin(0.109));
  const ParsedJson idle = engram_command(evaluation("--policy zero --episodes 10")).json();
  CHECK(idle["tasks"][0]["sr"] == 0.0);
}

TEST_CASE("eval: first answers and the score of memory", "[apps]") {
  const auto evaluate = [](const std::string& options) {
    const ParsedJson document = engram_command(evaluation("--episodes 40 " + options)).json();
    return document["tasks"][0];
  };
  const ParsedJson oracle = evaluate("--policy oracle");
  CHECK(oracle["first_answer_correct"] == 1.0);
  CHECK(oracle["first_answers_correct"] == std::vector<bool>(40, true));
  CHECK(oracle["memory_score"].get<double>() == Approx(1).margin(0.1));
  CHECK(oracle["answer_chance"].get<double>() == Approx(1.0 / 3));
  // A search succeeds more often than chance, but not with the first answer.
  const ParsedJson sweep = evaluate("--policy sweep");
  CHECK(sweep["sr"].get<double>() > 0.45);
  CHECK(sweep["first_answer_correct"].get<double>() < 0.6);
  CHECK(sweep["memory_score"].get<double>() == Approx(0).margin(0.4));
  // Right answers are those of the oracle for the same seeds.
  for (std::size_t i = 0; i < 40; ++i) {
    const bool same = sweep["first_answers"][i] == oracle["first_answers"][i];
    CHECK(sweep["first_answers_correct"][i] == same);
  }
  // Strict episodes fail with a wrong first answer; ceilings are not theirs.
  const ParsedJson strict = evaluate("--policy sweep --option strict=1");
  CHECK(strict["successes"] == strict["first_answers_correct"]);
  CHECK(strict["memory_score"].is_null());
  const ParsedJson idle = evaluate("--policy zero");
  CHECK(idle["first_answers"][0].is_null());
  CHECK(idle["first_answer_correct"] == 0.0);
}

TEST_CASE("eval: subtasks that were done", "[apps][labels]") {
  const auto evaluate = [](const std::string& options) {
    return engram_command(evaluation("--episodes 20 " + options)).json()["tasks"][0];
  };
  const ParsedJson oracle = evaluate("--policy oracle");
  CHECK(oracle["subtasks"] == std::vector<int>(20, 4));
  CHECK(oracle["subtasks_done"] == oracle["subtasks"]);
  CHECK(oracle["completion_rate"] == 1.0);
  // "Remember the color" and "wait" pass by themselves; to move to a cube and to touch it do not.
  const ParsedJson idle = evaluate("--policy zero");
  CHECK(idle["subtasks_done"] == std::vector<int>(20, 2));
  CHECK(idle["completion_rate"] == 0.5);
  const ParsedJson blind = evaluate("--policy blind");
  double sum = 0;
  for (std::size_t i = 0; i < 20; ++i) {
    const int done = blind["subtasks_done"][i].get<int>();
    CHECK((done == 4) == blind["successes"][i].get<bool>());
    sum += done / 4.0;
  }
  CHECK(blind["completion_rate"].get<double>() == Approx(sum / 20));
}

TEST_CASE("eval: tasks without an answer report null", "[apps]") {
  const ParsedJson task =
      engram_command("eval InterceptSlow-VLA-v0 --episodes 2 --json").json()["tasks"][0];
  for (const char* key : {"first_answers", "first_answers_correct", "first_answer_correct",
                          "answer_chance", "memory_score"}) {
    INFO(key);
    CHECK(task.at(key).is_null());
  }
}

TEST_CASE("eval: bytes do not depend on threads, batches or the order of ids", "[apps]") {
  for (const char* policy : {"oracle", "random"}) {
    const auto bytes = [policy](const std::string& ids, const std::string& options) {
      std::string arguments = "eval " + ids;
      arguments.append(" --json --episodes 20 --policy ")
          .append(policy)
          .append(" ")
          .append(options);
      const CommandResult result = engram_command(arguments);
      INFO(result.err);
      REQUIRE(result.code == 0);
      return result.out;
    };
    const std::string ids = std::string(kId) + " InterceptMedium-VLA-v0 TakeItBack-VLA-v0";
    const std::string expected = bytes(ids, "--num-envs 64 --threads 1");
    CHECK(expected == bytes(ids, "--num-envs 64 --threads 2"));
    CHECK(expected == bytes(ids, "--num-envs 8 --threads 2"));
    CHECK(expected == bytes(ids, "--num-envs 1 --threads 1"));
    CHECK(expected == bytes(ids, "--num-envs 3 --threads 5"));
    CHECK(expected == bytes(std::string("TakeItBack-VLA-v0 InterceptMedium-VLA-v0 ") + kId, ""));
  }
}

TEST_CASE("eval: result files", "[apps]") {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "new" / "results";
  const CommandResult result =
      engram_command(evaluation("RememberColor5-VLA-v0 --episodes 2 --out " + out.string()));
  const ParsedJson document = result.json();
  const std::filesystem::path run = only_entry(only_entry(out));
  CHECK(run.parent_path().filename() == "short");
  CHECK(run.filename().string().size() == std::string("2026-01-31_12-59-59").size());
  CHECK(read_file(run / "summary.json") == document["summary"].dump(2) + "\n");
  for (const ParsedJson& task : document["tasks"]) {
    const std::string name = task["env_id"].get<std::string>() + ".json";
    CHECK(read_file(run / name) == task.dump(2) + "\n");
  }
}

TEST_CASE("eval: resuming a finished run changes nothing", "[apps]") {
  const Run run;
  const auto before = results_in(run.path);
  CHECK(before.size() == 5);  // three tasks, summary, settings
  const auto time = std::filesystem::last_write_time(run.path / "TakeItBack-VLA-v0.json");
  const CommandResult again = engram_command(run.resume() + " --json");
  CHECK(again.json()["tasks"].size() == 3);
  CHECK(results_in(run.path) == before);
  CHECK(std::filesystem::last_write_time(run.path / "TakeItBack-VLA-v0.json") == time);
  // Repeating the command is allowed.
  CHECK(engram_command(run.command + "--resume " + run.path.string()).code == 0);
}

TEST_CASE("eval: lost and damaged files are rewritten, complete ones kept", "[apps]") {
  const Run run;
  const auto before = results_in(run.path);
  const std::filesystem::path lost = run.path / "RememberColor3-VLA-v0.json";
  const std::filesystem::path damaged = run.path / "RememberColor5-VLA-v0.json";
  const std::filesystem::path kept = run.path / "TakeItBack-VLA-v0.json";
  const auto time = std::filesystem::last_write_time(kept);
  const auto write = [](const std::filesystem::path& path, const std::string& text) {
    std::ofstream(path, std::ios::binary) << text;
  };
  const std::string whole = before.at("RememberColor5-VLA-v0.json");
  std::string lying = whole;  // a success too many for the rate
  lying.replace(lying.find("true"), 4, "false");
  const std::string others_file = before.at("TakeItBack-VLA-v0.json");
  for (const std::string& damage :
       {std::string(), whole.substr(0, whole.size() / 2), std::string("{}"), lying, others_file}) {
    std::filesystem::remove(lost);
    std::filesystem::remove(run.path / "summary.json");
    write(damaged, damage);
    const CommandResult result = engram_command(run.resume());
    INFO(result.err);
    CHECK(result.code == 0);
    CHECK(results_in(run.path) == before);
  }
  CHECK(std::filesystem::last_write_time(kept) == time);
}

TEST_CASE("eval: a folder belongs to one protocol", "[apps]") {
  const Run run;
  const auto before = results_in(run.path);
  require_refusal(run.resume() + " --episodes 5", 2, "n_episodes 4; 5 given now");
  require_refusal(run.resume() + " --policy blind", 2, "\"oracle\"; \"blind\" given now");
  require_refusal(run.resume() + " TakeItBack-VLA-v0", 2, "tasks");
  require_refusal(run.resume() + " --out " + run.folder.path().string(), 2, "--out");
  // Without its settings the folder still has results, which show the protocol.
  std::filesystem::remove(run.path / "settings.json");
  require_refusal(run.resume(), 2, "no task given");
  require_refusal(run.resume() + " RememberColor3-VLA-v0 --episodes 5", 2, "n_episodes");
  CHECK(results_in(run.path).at("TakeItBack-VLA-v0.json") == before.at("TakeItBack-VLA-v0.json"));
  require_refusal("eval --resume " + run.folder.path().string() + "/nothing", 1,
                  "nothing to resume");
  std::ofstream(run.path / "settings.json") << "{";
  require_refusal(run.resume(), 1, "settings.json");
}

// Fields that a run reads at its end are checked before it begins.
TEST_CASE("eval: incomplete results are rewritten", "[apps]") {
  const Run run;
  const auto before = results_in(run.path);
  const auto file = run.path / "TakeItBack-VLA-v0.json";
  for (const char* key : {"action_chunk_size", "episode_lengths", "mean_return", "split"}) {
    for (const bool gone : {true, false}) {
      ParsedJson task = ParsedJson::parse(before.at("TakeItBack-VLA-v0.json"));
      if (gone) {
        task.erase(key);
      } else {
        task[key] = ParsedJson::array({nullptr});
      }
      std::ofstream(file) << task;
      INFO(key << (gone ? " gone" : " of another type"));
      const CommandResult result = engram_command(run.resume());
      INFO(result.err);
      CHECK(result.code == 0);
      CHECK(results_in(run.path) == before);
    }
  }
}

TEST_CASE("eval: settings that were edited are refused", "[apps]") {
  const Run run;
  const std::string good = read_file(run.path / "settings.json");
  ParsedJson settings = ParsedJson::parse(good);
  settings["n_episodes"] = 3;
  std::ofstream(run.path / "settings.json") << settings;
  require_refusal(run.resume(), 1, "its checksum does not fit");
  settings = ParsedJson::parse(good);
  settings.erase("checksum");
  std::ofstream(run.path / "settings.json") << settings;
  require_refusal(run.resume(), 1, "its checksum does not fit");
  std::ofstream(run.path / "settings.json") << good;
  CHECK(engram_command(run.resume()).code == 0);
}

TEST_CASE("eval: settings that are no numbers are refused", "[apps]") {
  const Run run;
  const ParsedJson good = ParsedJson::parse(read_file(run.path / "settings.json"));
  for (const char* number : {"-1", "1e300", "2.5", "99999999999", "\"4\""}) {
    ParsedJson settings = good;
    settings["n_episodes"] = ParsedJson::parse(number);
    std::ofstream(run.path / "settings.json") << with_checksum(settings);
    require_refusal(run.resume(), 1, "a whole number up to");
  }
  std::ofstream(run.path / "settings.json") << std::string(1'000'000, '[');
  require_refusal(run.resume(), 1, "settings.json");
}

TEST_CASE("eval: a full disk is an error that loses nothing", "[apps]") {
  const Run run;
  const auto before = results_in(run.path);
  std::filesystem::remove(run.path / "RememberColor3-VLA-v0.json");
  // No file may grow beyond 512 bytes, which no result fits into.
  const std::string line = std::string("trap \"\" XFSZ; ulimit -f 1; ") + test::kNoTemporaryFolder +
                           "'" + test::kCommand + "' " + run.resume() +
                           " 2>&1 >/dev/null | cat > '" + (run.folder.path() / "err").string() +
                           "'";
  REQUIRE(std::system(("bash -c '" +
                       [](std::string text) {
                         for (std::size_t i = 0; (i = text.find('\'', i)) != std::string::npos;
                              i += 4)
                           text.replace(i, 1, "'\\''");
                         return text;
                       }(line) +
                       "'")
                          .c_str()) == 0);
  CHECK_THAT(read_file(run.folder.path() / "err"), Catch::Contains("cannot be written"));
  CHECK(results_in(run.path).at("TakeItBack-VLA-v0.json") == before.at("TakeItBack-VLA-v0.json"));
  CHECK(engram_command(run.resume()).code == 0);
  CHECK(results_in(run.path) == before);
  for (const auto& entry : std::filesystem::directory_iterator(run.path)) {
    CHECK(entry.path().extension() != ".engram-tmp");
  }
}

TEST_CASE("eval: what a killed run left half written is gone when it is resumed", "[apps]") {
  const Run run;
  std::filesystem::remove(run.path / "RememberColor3-VLA-v0.json");
  std::ofstream(run.path / "RememberColor3-VLA-v0.json.7.engram-tmp") << "half";
  std::ofstream(run.path / "samples" / "RememberColor3-VLA-v0.png.7.engram-tmp") << "half";
  CHECK(engram_command(run.resume()).code == 0);
  CHECK(std::filesystem::exists(run.path / "RememberColor3-VLA-v0.json"));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(run.path)) {
    CHECK(entry.path().extension() != ".engram-tmp");
  }
}

TEST_CASE("eval: the report holds everything", "[apps]") {
  const Run run;
  const std::string report = read_file(run.path / "report.html");
  CHECK_THAT(report, Catch::StartsWith("<!DOCTYPE html>") && Catch::Contains("class=\"bar\"") &&
                         Catch::Contains("TakeItBack-VLA-v0") &&
                         Catch::Contains("data:image/png;base64,iVBORw0KGgo"));
  CHECK_THAT(report, Catch::Contains("<td>Short</td>") && Catch::Contains("<td>CPU, ") &&
                         !Catch::Contains("processes"));
  // Nothing is loaded from anywhere.
  CHECK(report.find("src=\"http") == std::string::npos);
  CHECK(report.find("href=") == std::string::npos);
  CHECK(std::filesystem::file_size(run.path / "samples" / "TakeItBack-VLA-v0.png") > 1000);
}

TEST_CASE("eval: the report names the splits of its tasks", "[apps]") {
  const TemporaryFolder folder;
  REQUIRE(engram_command(
              "eval RememberColor3-VLA-v0 RememberColor3-Long-VLA-v0 --episodes 1 --policy zero "
              "--threads 1 --out " +
              folder.path().string())
              .code == 0);
  const std::string report = read_file(only_entry(folder.path() / "all") / "report.html");
  CHECK_THAT(report, Catch::Contains("<td>Medium, Short</td>") &&
                         Catch::Contains("<td>CPU, 1 thread</td>") && !Catch::Contains("Custom"));
}

TEST_CASE("eval: options of tasks", "[apps]") {
  require_refusal(evaluation("--episodes 1 --option no_such_option=1"), 2, "no_such_option");
}

TEST_CASE("eval: a policy in a process of its own", "[apps]") {
  const CommandResult result = engram_command(python_policy(kPipePolicy));
  const ParsedJson task = result.json()["tasks"][0];
  CHECK(task["obs_mode"] == "rgb");
  CHECK(task["action_chunk_size"] == 4);
  CHECK(task["model"]["name"] == "external");
  CHECK(task["model"]["config"]["command"] == kPipePolicy);
  CHECK(task["episode_lengths"] == std::vector<int>(3, 25));
  // Its answers depend on its observation, not on the other episodes of a request.
  const std::string base = evaluation("--episodes 3 --policy-command '" + kPipePolicy + "' ");
  CHECK(engram_command(base + "--num-envs 1 --threads 2").out == result.out);
  const ParsedJson state = engram_command(base + "--obs state").json()["tasks"][0];
  CHECK(state["obs_mode"] == "state");
  CHECK(state["returns"] != task["returns"]);
  const ParsedJson objects = engram_command(base + "--obs objects").json()["tasks"][0];
  CHECK(objects["obs_mode"] == "objects");
  CHECK(objects["returns"] != task["returns"]);
  CHECK(objects["returns"] != state["returns"]);
}

TEST_CASE("eval: a policy process that fails is reported", "[apps]") {
  require_refusal(python_policy("exit 3"), 1, "ended with exit code 3");
  require_refusal(python_policy("kill -9 $$"), 1, "signal 9");
  require_refusal(python_policy("echo hello, world; cat >/dev/null"), 1, "standard output");
  require_refusal(evaluation("--policy-timeout 1 --policy-command 'sleep 100'"), 1, "within 1 s");
  require_refusal(python_policy(kPipePolicy) + " --policy oracle", 2, "--policy");
}

TEST_CASE("eval: a folder that cannot be made is reported before the run", "[apps]") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "file").string();
  std::ofstream(file) << "in the way";
  require_refusal(evaluation("--episodes 100000 --out " + file + "/results"), 1, file);
}

TEST_CASE("eval: filters skip families that are not there", "[apps]") {
  const CommandResult result =
      engram_command("eval --canonical --split short --episodes 1 --policy zero --json");
  const ParsedJson document = result.json();
  CHECK(document["summary"]["split"] == "Short");
  CHECK(!document["tasks"].empty());
  if (document["tasks"].size() < 38) CHECK_THAT(result.err, Catch::Contains("of 38 tasks skipped"));
}

TEST_CASE("eval: text output", "[apps]") {
  const CommandResult result =
      engram_command(std::string("eval --episodes 1 --policy zero ") + kId);
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Contains(kId) && Catch::Contains("mean over 1 task:"));
}

}  // namespace engram::test
