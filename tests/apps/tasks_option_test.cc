// The command with tasks out of a library (docs/cpp_tasks.md).
#include <filesystem>
#include <fstream>

#include "tests/apps/command.h"
#include "tests/apps/fake_python.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "TouchSpot-VLA-v0";

std::string library(const std::string& name) {
  return std::string(test::kTaskLibraries) + "/lib" + name + ".so";
}
std::string tasks() { return " --tasks '" + library("touch_spot") + "'"; }

double success(const std::string& policy) {
  const TemporaryFolder folder;
  const std::string out = folder.path().string() + "/out";
  const ParsedJson results =
      engram_command("eval " + std::string(kId) + " --episodes 300 --policy " + policy +
                     " --json --out '" + out + "'" + tasks())
          .json();
  return results["tasks"][0]["sr"];
}

}  // namespace

TEST_CASE("A library's tasks work in every command", "[apps][task_library]") {
  CHECK_THAT(engram_command("list" + tasks()).out,
             Catch::Contains(kId) && Catch::Contains("130 tasks"));
  CHECK_THAT(engram_command(tasks() + " info " + kId).out, Catch::Contains("horizon 30"));
  require_refusal(std::string("info ") + kId, 2, "no task");
  const ParsedJson checked =
      engram_command(std::string("verify ") + kId + " --obs state --json" + tasks()).json();
  CHECK(checked[0]["different"] == 0);
  const TemporaryFolder folder;
  const std::string image = (folder.path() / "x.png").string();
  CHECK(engram_command(std::string("record ") + kId + " --out " + image + " --sheet 2" + tasks())
            .code == 0);
  require_refusal(std::string("rollout ") + kId + " --set GOAL_THRESH=9" + tasks(), 2,
                  "'GOAL_THRESH': 9 given");
}

TEST_CASE("A library's oracle succeeds and its blind policy guesses", "[apps][task_library]") {
  CHECK(success("oracle") == 1.0);
  CHECK(success("blind") == Approx(1.0 / 3).margin(0.1));
  CHECK(success("zero") == 0);
}

TEST_CASE("ENGRAM_TASKS names libraries, whose tasks variants may change", "[apps][task_library]") {
  const TemporaryFolder folder;
  const fs::path variants = folder.path() / "variants.json";
  std::ofstream(variants) << R"({"variants": [{"id": "TouchSpot-Slow-v0",
    "base": "TouchSpot-VLA-v0", "constants": {"CUE_PHASE_STEPS": [6, 8]}}]})";
  const std::string both =
      "ENGRAM_TASKS=':" + library("touch_spot") + ":' ENGRAM_VARIANTS='" + variants.string() + "'";
  CHECK_THAT(engram_command("list", "", both).out, Catch::Contains("TouchSpot-Slow-v0"));
  // Options may stand in any order.
  CHECK_THAT(engram_command("info TouchSpot-Slow-v0 --variants " + variants.string() + tasks()).out,
             Catch::Contains("horizon 30"));
  const CommandResult result =
      engram_command("list", "", "ENGRAM_TASKS='" + library("other_version") + "'");
  CHECK(result.code == 2);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Catch::Contains("libother_version.so': made for engram '0.0.1'"));
}

TEST_CASE("Libraries are handed on to Python, before variants", "[apps][task_library]") {
  const TemporaryFolder folder;
  const std::string variants = std::string(test::kRoot) + "/apps/examples/medium_variants.json";
  const std::string options = " --variants " + variants + tasks();
  const std::string python = fake_python(folder, kPrintArguments);
  const CommandResult played = engram_command("play --stay" + options, "", python);
  const std::string words = "--tasks=" + library("touch_spot") + "\n--variants=" + variants + "\n";
  CHECK(played.out == words + "--stay\n");
  const std::string collect =
      std::string("collect ") + kId + " --format lerobot --out " + (folder.path() / "out").string();
  const CommandResult collected = engram_command(collect + options, "", python);
  CHECK_THAT(collected.out, Catch::Contains("--word=--tasks=" + library("touch_spot") +
                                            "\n--word=--variants=" + variants + "\n"));
}

TEST_CASE("A library that does not fit is refused by every command", "[apps][task_library]") {
  require_refusal("list --tasks /nowhere/libtasks.so", 1, "cannot be read");
  for (const char* name : {"no_entry", "other_abi", "other_headers", "taken_id"}) {
    require_refusal("list --tasks " + library(name), 2, library(name));
  }
}

}  // namespace engram::test
