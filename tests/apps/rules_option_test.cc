// --rules in every command that makes environments, and in their results.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "SeqOfColors3-VLA-v0";

// Values of a task's options as `info` has them.
std::map<std::string, double> option_values(const std::string& arguments) {
  const ParsedJson task = engram_command(std::string("info --json ") + kId + arguments).json();
  std::map<std::string, double> values;
  for (const ParsedJson& option : task["options"]) values[option["name"]] = option["value"];
  return values;
}

fs::path only_entry(const fs::path& folder) {
  REQUIRE(std::distance(fs::directory_iterator(folder), {}) == 1);
  return fs::directory_iterator(folder)->path();
}

}  // namespace

TEST_CASE("rules: info shows the options of a rule set", "[apps][rules]") {
  using Values = std::map<std::string, double>;
  const Values reference = {{"strict", 0}, {"strict_order", 0}, {"touch_radius", 0.05}};
  CHECK(option_values("") == reference);
  CHECK(option_values(" --rules reference") == reference);
  CHECK(option_values(" --rules original") ==
        Values{{"strict", 0}, {"strict_order", 1}, {"touch_radius", 0.02}});
  CHECK(option_values(" --rules original --option touch_radius=0.05") ==
        Values{{"strict", 0}, {"strict_order", 1}, {"touch_radius", 0.05}});
  CHECK(option_values(" --option touch_radius=0.05 --rules original") ==
        Values{{"strict", 0}, {"strict_order", 1}, {"touch_radius", 0.05}});
  const ParsedJson task = engram_command(std::string("info --json --rules original ") + kId).json();
  CHECK(task["rules"] == "original");
  CHECK(task["options"][0]["default"] == 0.05);
  CHECK(task["options"][0]["original"] == 0.02);
  const CommandResult words = engram_command(std::string("info --rules original ") + kId);
  CHECK_THAT(words.out, Catch::Contains("rules original"));
}

TEST_CASE("rules: unknown rule sets are refused", "[apps][rules]") {
  const std::string task = std::string(" ") + kId + " ";
  for (const std::string& command :
       {"info" + task, "rollout" + task, "record" + task + "--out nowhere.png ", "eval" + task,
        "collect" + task}) {
    require_refusal(command + "--rules upstream", 2,
                    "--rules: 'upstream' given, reference|original allowed");
  }
}

TEST_CASE("rules: rollouts follow and report them", "[apps][rules]") {
  const auto rollout = [](const std::string& rules) {
    return engram_command(std::string("rollout ShellGameColorLampTouch-VLA-v0 --num-envs 16 ") +
                          "--steps 8 --hash --json " + rules)
        .json();
  };
  const ParsedJson reference = rollout("");
  const ParsedJson original = rollout("--rules original");
  CHECK(reference["rules"] == "reference");
  CHECK(original["rules"] == "original");
  CHECK(original["hash"] != reference["hash"]);
  CHECK(original["hash"] == rollout("--option fixed_mapping=1")["hash"]);
  CHECK(reference["hash"] == rollout("--rules original --option fixed_mapping=0")["hash"]);
}

TEST_CASE("rules: results name them, and a folder has one rule set", "[apps][rules]") {
  const TemporaryFolder folder;
  const std::string command = std::string("eval TakeItBack-VLA-v0 RotateLenientPos-VLA-v0 ") +
                              "--episodes 2 --policy zero --json ";
  const ParsedJson document =
      engram_command(command + "--rules original --out " + folder.path().string()).json();
  for (const ParsedJson& task : document["tasks"]) CHECK(task["rules"] == "original");
  const fs::path results = only_entry(folder.path() / "short");
  CHECK(ParsedJson::parse(read_file(results / "settings.json"))["rules"] == "original");
  CHECK(ParsedJson::parse(read_file(results / "TakeItBack-VLA-v0.json"))["rules"] == "original");
  CHECK_THAT(read_file(results / "report.html"), Catch::Contains("original"));
  const std::string resume = "eval --resume " + results.string();
  CHECK(engram_command(resume).code == 0);
  CHECK(engram_command(resume + " --rules original").code == 0);
  require_refusal(resume + " --rules reference", 2,
                  "has results of rules \"original\"; \"reference\" given now");
}

TEST_CASE("rules: data sets name them, and a folder has one rule set", "[apps][rules]") {
  const TemporaryFolder folder;
  const std::string command =
      "collect BlinkCountButtonPressEasy-VLA-v0 --episodes 1 --out " + folder.path().string() + " ";
  const auto metadata = [&folder] {
    return ParsedJson::parse(read_file(folder.path() / "data_npz" /
                                       "BlinkCountButtonPressEasy-VLA-v0" / "metadata.json"));
  };
  REQUIRE(engram_command(command + "--rules original").code == 0);
  CHECK(metadata()["engram"]["rules"] == "original");
  require_refusal(command, 2, "was collected with rules \"original\", \"reference\" given");
  CHECK(metadata()["engram"]["rules"] == "original");
  CHECK(engram_command(command + "--rules original").code == 0);
}

TEST_CASE("rules: constants without effect are warned of, once", "[apps][rules]") {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  const std::string given = " SeqOfColors3-VLA-v0 --set GOAL_THRESH=0.08";
  const std::string two = " BunchOfColors3-VLA-v0" + given;
  for (const std::string& command : {"info" + given, "rollout --steps 1 --num-envs 1" + given,
                                     "record --steps 1 --out " + out + "/one.png" + given,
                                     "eval --episodes 1 --policy zero" + two,
                                     "collect --episodes 1 --max-attempts 1 --out " + out + two}) {
    INFO(command);
    const CommandResult warned = engram_command(command + " --rules original");
    CHECK_THAT(warned.err, Catch::StartsWith("engram: warning: GOAL_THRESH=0.08 has no effect on "
                                             "touch_radius, which is 0.02 with rules=original"));
    CHECK(warned.err.find("GOAL_THRESH") == warned.err.rfind("GOAL_THRESH"));
    CHECK(engram_command(command).err.find("GOAL_THRESH") == std::string::npos);
  }
  CHECK(engram_command("info --json --rules original" + given).json()["warnings"].size() == 1);
  CHECK(engram_command("info --json" + given).json()["warnings"].empty());
}

}  // namespace engram::test
