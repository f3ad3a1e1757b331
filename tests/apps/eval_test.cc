// `engram eval`: the protocol, its files, and that neither threads nor batches show in results.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/apps/command.h"

namespace engram::tests {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

std::string evaluation(const std::string& options) {
  return std::string("eval ") + kId + " --json " + options;
}

}  // namespace

TEST_CASE("eval: documents of the protocol", "[apps]") {
  const Json document = engram_command(evaluation("--episodes 5")).json();
  CHECK(keys_of(document) == std::vector<std::string>{"summary", "tasks"});
  CHECK(keys_of(document["summary"]) ==
        std::vector<std::string>{"split", "sr_split", "sr_per_memory_type", "tasks", "per_task_sr",
                                 "per_task_mean_return"});
  REQUIRE(document["tasks"].size() == 1);
  const Json& task = document["tasks"][0];
  CHECK(keys_of(task) ==
        std::vector<std::string>{"env_id", "split", "memory_type", "start_seed", "n_episodes",
                                 "successes", "returns", "sr", "mean_return", "chance",
                                 "benchmark_commit", "control_mode", "obs_mode", "wrapper_chain",
                                 "action_chunk_size", "model", "episode_lengths", "episode_seeds"});
  CHECK(task["split"] == "Short");
  CHECK(task["memory_type"] == "Object");
  CHECK(task["start_seed"] == 4242424242);
  CHECK(task["successes"] == std::vector<bool>(5, true));
  CHECK(task["episode_lengths"] == std::vector<int>(5, 25));
  CHECK(task["episode_seeds"][4] == 4242424246);
  CHECK(task["chance"].get<double>() == Approx(1.0 / 3));
  CHECK(task["model"]["name"] == "oracle");
  CHECK(document["summary"]["sr_per_memory_type"]["Object"] == 1.0);
}

TEST_CASE("eval: the oracle remembers, the blind one guesses", "[apps]") {
  const Json oracle = engram_command(evaluation("--policy oracle")).json();
  CHECK(oracle["tasks"][0]["n_episodes"] == 50);
  CHECK(oracle["tasks"][0]["sr"].get<double>() >= 0.95);
  const Json blind = engram_command(evaluation("--policy blind --episodes 300")).json();
  // Four standard deviations of 300 guesses.
  CHECK(blind["tasks"][0]["sr"].get<double>() == Approx(1.0 / 3).margin(0.109));
  const Json idle = engram_command(evaluation("--policy zero --episodes 10")).json();
  CHECK(idle["tasks"][0]["sr"] == 0.0);
}

TEST_CASE("eval: bytes do not depend on threads or batches", "[apps]") {
  for (const char* policy : {"oracle", "random"}) {
    const std::string base = std::string("--policy ") + policy;
    const CommandResult whole = engram_command(evaluation(base + " --num-envs 50 --threads 1"));
    REQUIRE(whole.code == 0);
    CHECK(whole.out == engram_command(evaluation(base + " --num-envs 50 --threads 2")).out);
    CHECK(whole.out == engram_command(evaluation(base + " --num-envs 8 --threads 2")).out);
    CHECK(whole.out == engram_command(evaluation(base + " --num-envs 1 --threads 1")).out);
  }
}

TEST_CASE("eval: result files", "[apps]") {
  const TemporaryFolder folder;
  const std::filesystem::path out = folder.path() / "new" / "results";
  const CommandResult result =
      engram_command(evaluation("RememberColor5-VLA-v0 --episodes 2 --out " + out.string()));
  const Json document = result.json();
  CHECK(std::filesystem::exists(out / "short"));
  std::vector<std::filesystem::path> runs;
  for (const auto& entry : std::filesystem::directory_iterator(out / "short")) {
    runs.push_back(entry.path());
  }
  REQUIRE(runs.size() == 1);
  CHECK(read_file(runs[0] / "summary.json") == document["summary"].dump(2) + "\n");
  for (const Json& task : document["tasks"]) {
    const std::string name = task["env_id"].get<std::string>() + ".json";
    CHECK(read_file(runs[0] / name) == task.dump(2) + "\n");
  }
}

TEST_CASE("eval: a folder that cannot be made is told before anything runs", "[apps]") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "file").string();
  std::ofstream(file) << "in the way";
  require_refusal(evaluation("--episodes 100000 --out " + file + "/results"), 1, file);
}

TEST_CASE("eval: filters skip families that are not there", "[apps]") {
  const CommandResult result =
      engram_command("eval --canonical --split short --episodes 1 --policy zero --json");
  const Json document = result.json();
  CHECK(document["summary"]["split"] == "Short");
  CHECK(!document["tasks"].empty());
  if (document["tasks"].size() < 38) CHECK_THAT(result.err, Catch::Contains("of 38 tasks skipped"));
}

TEST_CASE("eval: in words", "[apps]") {
  const CommandResult result =
      engram_command(std::string("eval --episodes 1 --policy zero ") + kId);
  CHECK(result.code == 0);
  CHECK_THAT(result.out, Catch::Contains(kId) && Catch::Contains("mean over 1 tasks"));
}

}  // namespace engram::tests
