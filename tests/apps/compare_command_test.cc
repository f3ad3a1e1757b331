// `engram compare`: results that were evaluated, as text and as JSON.
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

constexpr const char* kIds = "RememberColor3-VLA-v0 TakeItBack-VLA-v0 ";

// Results of an evaluation in a file.
std::string evaluated(const TemporaryFolder& folder, const std::string& name,
                      const std::string& options) {
  const std::string path = (folder.path() / name).string();
  const CommandResult result = engram_command("eval --json " + options);
  INFO(result.err);
  REQUIRE(result.code == 0);
  std::ofstream(path) << result.out;
  return path;
}

TEST_CASE("compare: two policies on the same episodes", "[apps]") {
  const TemporaryFolder folder;
  const std::string a = evaluated(folder, "a", std::string(kIds) + "--episodes 20");
  const std::string b = evaluated(folder, "b", std::string(kIds) + "--episodes 20 --policy blind");
  const ParsedJson comparison = engram_command("compare " + a + " " + b + " --json").json();
  CHECK(keys_of(comparison) == std::vector<std::string>{"a", "b", "tasks", "splits", "total"});
  CHECK(keys_of(comparison["a"]) == std::vector<std::string>{"source", "model", "version", "rules",
                                                             "obs_mode", "latency_steps", "repeat",
                                                             "physics"});
  const std::vector<std::string> figures = {"pairs",
                                            "sr_a",
                                            "sr_b",
                                            "difference",
                                            "difference_interval",
                                            "p_value",
                                            "test",
                                            "both",
                                            "only_a",
                                            "only_b",
                                            "neither",
                                            "smallest_difference",
                                            "detectable_difference",
                                            "same_digests"};
  std::vector<std::string> of_task = {"env_id", "split"};
  of_task.insert(of_task.end(), figures.begin(), figures.end());
  of_task.emplace_back("p_value_holm");
  REQUIRE(comparison["tasks"].size() == 2);
  CHECK(keys_of(comparison["tasks"][0]) == of_task);
  const ParsedJson& total = comparison["total"];
  CHECK(total["pairs"] == 40);
  CHECK(total["sr_a"] == 1.0);
  CHECK(total["p_value"].get<double>() < 0.001);
  CHECK(total["same_digests"]["first_observations"] == 40);
  CHECK(total["same_digests"]["observations"].get<int>() < 40);
  const CommandResult text = engram_command("compare " + a + " " + b);
  CHECK(text.code == 0);
  CHECK_THAT(text.out, Catch::Contains("A: oracle in " + a) && Catch::Contains("split Short") &&
                           Catch::Contains("exact McNemar, two-sided") &&
                           Catch::Contains("smallest difference") &&
                           Catch::Contains("alike of 40 episodes: first observations 40"));
  // Equal results differ in nothing.
  const ParsedJson same = engram_command("compare " + a + " " + a + " --json").json()["total"];
  CHECK(same["p_value"] == 1.0);
  CHECK(same["same_digests"]["answers"] == 40);
}

TEST_CASE("compare: refusals are one line and say what to allow", "[apps]") {
  const TemporaryFolder folder;
  const std::string a = evaluated(folder, "a", std::string(kIds) + "--episodes 2");
  const std::string fewer = evaluated(folder, "fewer", "TakeItBack-VLA-v0 --episodes 2");
  const std::string later = evaluated(folder, "later", "TakeItBack-VLA-v0 --episodes 2 --seed 1");
  const std::string other =
      evaluated(folder, "other", "TakeItBack-VLA-v0 --episodes 2 --rules original");
  require_refusal("compare " + a + " " + fewer, 2, "has RememberColor3-VLA-v0");
  CHECK(engram_command("compare " + a + " " + fewer + " --allow ids").code == 0);
  require_refusal("compare " + later + " " + fewer + " --allow seeds", 2, "do not pair");
  require_refusal("compare " + other + " " + fewer, 2, "rules \"original\"");
  CHECK(engram_command("compare " + other + " " + fewer + " --allow rules").code == 0);
  require_refusal("compare " + a + " " + fewer + " --allow everything", 2,
                  "ids, seeds, version, rules, constants, choices, physics allowed");
  require_refusal("compare " + a + " " + a + "no", 1, "does not exist");
  require_refusal("compare " + a, 2, "B");
}

}  // namespace
}  // namespace engram::test
