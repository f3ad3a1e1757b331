// The command with constants and ids of users' own.
#include <filesystem>
#include <fstream>

#include "tests/apps/command.h"
#include "tests/apps/fake_python.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "Slow-Color2-v0";
constexpr const char* kFile = R"({"variants": [{
  "id": "Slow-Color2-v0", "base": "RememberColor9-VLA-v0", "instruction": "Touch it.",
  "constants": {"COLORS": 2, "CUE_PHASE_STEPS": [10, 12], "max_episode_steps": 40}}]})";

// A file of one variant.
struct VariantsFile {
  TemporaryFolder folder;
  fs::path path = folder.path() / "variants.json";
  std::string option = " --variants " + path.string();

  explicit VariantsFile(const std::string& text = kFile) { std::ofstream(path) << text; }
};

const ParsedJson& constant(const ParsedJson& description, const std::string& name) {
  for (const ParsedJson& one : description["changeable"]) {
    if (one["name"] == name) return one;
  }
  FAIL("no constant " << name);
  throw;
}

}  // namespace

TEST_CASE("Constants change by --set, and info lists them", "[apps][variants]") {
  const ParsedJson plain = engram_command("info RememberShape5-VLA-v0 --json").json();
  CHECK(constant(plain, "SHAPES")["value"] == 5);
  CHECK(constant(plain, "SHAPES")["low"] == 2);
  CHECK(constant(plain, "SHAPES")["kind"] == "integer");
  CHECK(plain["changed"].empty());
  const ParsedJson changed =
      engram_command(
          "info RememberShape5-VLA-v0 --json --set SHAPES=2 --set SHAPE_MAPPING=star,cube "
          "--set GOAL_THRESH=0.04 --set CUE_PHASE_STEPS=2,3 --set EMPTY_PHASE_STEPS=4")
          .json();
  CHECK(changed["candidates"] == 2);
  CHECK(constant(changed, "SHAPE_MAPPING")["value"] == ParsedJson({"star", "cube"}));
  CHECK(constant(changed, "CUE_PHASE_STEPS")["value"] == ParsedJson({2, 3}));
  CHECK(constant(changed, "EMPTY_PHASE_STEPS")["value"] == ParsedJson({4, 4}));
  CHECK(changed["changed"]["GOAL_THRESH"] == 0.04);
  CHECK_THAT(engram_command("info RememberShape5-VLA-v0 --set SHAPES=3").out,
             Catch::Contains("Constants that can be changed"));
  const ParsedJson rollout =
      engram_command(
          "rollout RememberColor9-VLA-v0 --policy oracle --num-envs 8 --steps 40 "
          "--set COLORS=2 --json")
          .json();
  CHECK(rollout["success_once"] == 1.0);
}

TEST_CASE("Constants that cannot be are refused in one line", "[apps][variants]") {
  const TemporaryFolder folder;
  const std::string out = " --out " + folder.path().string() + "/out";
  for (const std::string& command :
       {std::string("rollout"), std::string("info"), "eval" + out, "collect" + out,
        "record" + out + ".png", std::string("verify")}) {
    const std::string line = command + " RememberColor9-VLA-v0 --set ";
    require_refusal(line + "COLOURS=3", 2, "did you mean 'COLORS'");
    require_refusal(line + "COLORS=12", 2, "a whole number from 2 to 9 allowed");
  }
  CHECK(fs::is_empty(folder.path()));
  for (const char* text : {"COLORS", "=3", "COLORS=", "COLORS=3,"}) {
    require_refusal(std::string("rollout RememberColor9-VLA-v0 --set ") + text, 2, "NAME=VALUE");
  }
}

TEST_CASE("Ids out of a file work in every command", "[apps][variants]") {
  const VariantsFile file;
  CHECK_THAT(engram_command("list" + file.option).out,
             Catch::Contains(kId) && Catch::Contains("130 tasks"));
  CHECK_THAT(engram_command(file.option + " info " + kId).out, Catch::Contains("Touch it."));
  const std::string by_variable = "ENGRAM_VARIANTS='" + file.path.string() + "'";
  CHECK_THAT(engram_command(std::string("info ") + kId, "", by_variable).out,
             Catch::Contains("horizon 40"));
  require_refusal(std::string("info ") + kId, 2, "did you mean");

  const ParsedJson checked =
      engram_command(std::string("verify ") + kId + " --obs state --json" + file.option).json();
  CHECK(checked[0]["different"] == 0);
  CHECK(engram_command(std::string("record ") + kId + " --out " +
                       (file.folder.path() / "x.png").string() + " --sheet 2" + file.option)
            .code == 0);
}

TEST_CASE("Variants are handed on to the streams of a LeRobotDataset", "[apps][variants]") {
  const VariantsFile file;
  const CommandResult result =
      engram_command(std::string("collect ") + kId + " --format lerobot --set COLORS=3 --out " +
                         (file.folder.path() / "out").string() + file.option,
                     "", fake_python(file.folder, kPrintArguments));
  CHECK_THAT(result.out, Catch::Contains("--word=--variants=" + file.path.string() + "\n") &&
                             Catch::Contains("--word=--set=COLORS=3\n"));
}

TEST_CASE("Evaluations of variants name them, and continue with the same ones only",
          "[apps][variants]") {
  const VariantsFile file;
  const fs::path out = file.folder.path() / "out";
  const std::string command = std::string("eval ") + kId + " RememberColor3-VLA-v0 --episodes 4 ";
  REQUIRE(engram_command(command + "--out " + out.string() + file.option).code == 0);
  fs::path run;
  for (const auto& entry : fs::directory_iterator(out / "short")) run = entry.path();
  const fs::path result = run / (std::string(kId) + ".json");
  const ParsedJson document = ParsedJson::parse(read_file(result));
  CHECK(document["sr"] == 1.0);
  CHECK(document["variant"]["base"] == "RememberColor9-VLA-v0");
  CHECK(document["variant"]["constants"]["CUE_PHASE_STEPS"] == ParsedJson({10, 12}));
  CHECK_FALSE(ParsedJson::parse(read_file(run / "RememberColor3-VLA-v0.json")).contains("variant"));

  // The folder has the id's constants; with others it is not continued.
  const std::string before = read_file(result);
  fs::remove(result);
  REQUIRE(engram_command("eval --resume " + run.string()).code == 0);
  CHECK(read_file(result) == before);
  const VariantsFile other(
      R"({"variants": [{"id": "Slow-Color2-v0", "base": "RememberColor3-VLA-v0"}]})");
  require_refusal("eval --resume " + run.string() + other.option, 1, "defined in another way");
  require_refusal("eval --resume " + run.string() + " --set COLORS=3", 2, "constants");
}

TEST_CASE("A data set continues with the same constants only", "[apps][variants]") {
  const VariantsFile file;
  const std::string out = " --out " + (file.folder.path() / "data").string();
  const std::string command = std::string("collect ") + kId + " --episodes 1" + out + file.option;
  REQUIRE(engram_command(command).code == 0);
  const fs::path metadata = file.folder.path() / "data" / "data_npz" / kId / "metadata.json";
  const ParsedJson document = ParsedJson::parse(read_file(metadata));
  CHECK(document["engram"]["variant"]["constants"]["COLORS"] == 2);
  require_refusal(command + " --set COLORS=3", 2, "was collected with variant");
  CHECK(engram_command(command).code == 0);
}

TEST_CASE("A damaged file of variants is refused by every command", "[apps][variants]") {
  const VariantsFile damaged(
      R"({"variants": [{"id": "A-v0", "base": "RememberColor3-VLA-v0"}, 7]})");
  require_refusal("list" + damaged.option, 2, "a variant has to be a table");
  const CommandResult result =
      engram_command("list", "", "ENGRAM_VARIANTS='" + damaged.path.string() + "'");
  CHECK(result.code == 2);
  CHECK_THAT(result.err, Catch::Contains(damaged.path.string()));
  require_refusal("list --variants /nowhere/variants.json", 1, "cannot be read");
}

TEST_CASE("The option set takes every constant as info prints it", "[apps][variants]") {
  for (const char* id :
       {"RememberShapeAndColor3x2-VLA-v0", "TraceShapeHard-VLA-v0", "BatteriesCheckerEasy-3-VLA-v0",
        "ShellGameShuffleColorLampTouch-VLA-v0"}) {
    INFO(id);
    const std::string info = std::string("info ") + id + " --json";
    const ParsedJson plain = engram_command(info).json();
    std::string settings;
    for (const auto& [name, value] : plain["constants"].items()) {
      settings += " --set '" + name + "=" +
                  (value.is_string() ? value.get<std::string>() : value.dump()) + "'";
    }
    CHECK(engram_command(info + settings).json() == plain);
  }
  const ParsedJson colored = engram_command(
                                 "info RememberShapeAndColor3x2-VLA-v0 --json --set SHAPES=4 "
                                 "--set 'COLOR_PALETTE={\"0\": [1, 0.5, 0.1, 1], \"1\": \"Blue\"}'")
                                 .json();
  CHECK(constant(colored, "COLOR_PALETTE")["value"] == ParsedJson({{1.0, 0.5, 0.1}, "blue"}));
  CHECK(constant(colored, "COLOR_PALETTE")["kind"] == "colors");
  CHECK(colored["constants"]["COLOR_PALETTE"]["1"] == ParsedJson({0.0, 0.0, 1.0, 1.0}));
  require_refusal("info RememberColor3-VLA-v0 --set 'COLORS=[1,'", 2, "NAME=JSON");
  require_refusal("info RememberColor3-VLA-v0 --set HEIGHT_OFFSET=1", 2, "did you mean");
}

}  // namespace engram::test
