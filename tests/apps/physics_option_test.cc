// --physics of the commands: what it changes, and where results and data sets name it.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "core/scene/mujoco_handle.h"
#include "protocol/io/files.h"
#include "tests/apps/command.h"
#include "tests/sanitizers.h"

namespace engram::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kId = "RememberColor3-VLA-v0";
constexpr const char* kMujoco = " --physics mujoco";

// The only run in a folder of results.
fs::path run_in(const TemporaryFolder& folder) {
  return fs::directory_iterator(folder.path() / "short")->path();
}

ParsedJson read_json(const fs::path& file) { return ParsedJson::parse(read_file(file)); }

// A run of results, written into the folder.
fs::path evaluate(const TemporaryFolder& folder, const std::string& options) {
  const CommandResult result = engram_command(std::string("eval ") + kId + " --episodes 2 --out " +
                                              folder.path().string() + options);
  INFO(result.err);
  REQUIRE(result.code == 0);
  return run_in(folder);
}

}  // namespace

TEST_CASE("eval: results of MuJoCo's physics name it and its version", "[apps][mujoco_physics]") {
  const TemporaryFolder folder;
  const TemporaryFolder usual_folder;
  const fs::path run = evaluate(folder, kMujoco);
  const fs::path usual = evaluate(usual_folder, "");
  const std::string file = std::string(kId) + ".json";

  CHECK(read_json(run / "settings.json")["physics"] == "mujoco");
  CHECK(read_json(run / "settings.json")["mujoco_version"] == mj_versionString());
  CHECK(read_json(usual / "settings.json")["physics"] == "engram");
  CHECK_FALSE(read_json(usual / "settings.json").contains("mujoco_version"));

  const ParsedJson task = read_json(run / file);
  CHECK(task["physics"] == "mujoco");
  CHECK(task["mujoco_version"] == mj_versionString());
  CHECK(task["sr"] == 1);
  CHECK(task["memory_score"].is_null());
  CHECK_FALSE(read_json(usual / file).contains("physics"));
  CHECK(read_json(usual / file)["memory_score"] == 1);
  CHECK(task["digests"] != read_json(usual / file)["digests"]);
  CHECK_THAT(read_file(run / "report.html"),
             Catch::Contains(std::string("mujoco ") + mj_versionString()));

  require_refusal("compare " + run.string() + " " + usual.string(), 2, "allow physics");
  const ParsedJson compared =
      engram_command("compare " + run.string() + " " + usual.string() + " --allow physics --json")
          .json();
  CHECK(compared["a"]["physics"] == "mujoco");
  CHECK(compared["b"]["physics"] == "engram");
}

TEST_CASE("eval: a run is not resumed under another physics", "[apps][mujoco_physics]") {
  const TemporaryFolder folder;
  const fs::path run = evaluate(folder, kMujoco);
  CHECK(engram_command("eval --resume " + run.string()).code == 0);
  require_refusal("eval --physics engram --resume " + run.string(), 2,
                  "physics \"mujoco\"; \"engram\" given now");
  ParsedJson settings = read_json(run / "settings.json");
  settings["mujoco_version"] = "1.0.0";
  write_file(run / "settings.json", with_checksum(settings));
  require_refusal("eval --resume " + run.string(), 1, "mujoco_version is \"1.0.0\", here");
}

TEST_CASE("collect: folders are of one physics", "[apps][mujoco_physics]") {
  const TemporaryFolder folder;
  const std::string command = std::string("collect ") + kId +
                              " --episodes 2 --renderer cpu --out " + folder.path().string();
  REQUIRE(engram_command(command + kMujoco).code == 0);
  const ParsedJson metadata =
      read_json(folder.path() / "data_npz" / kId / "metadata.json")["engram"];
  CHECK(metadata["physics"] == "mujoco");
  CHECK(metadata["mujoco_version"] == mj_versionString());
  require_refusal(command, 2, "was collected with physics \"mujoco\", \"engram\" given");
}

TEST_CASE("rollout, verify, probe, bench and soak have a physics", "[apps][mujoco_physics]") {
  const std::string id = kId;
  const std::string rollout = "rollout " + id + " --num-envs 3 --steps 20 --hash --json";
  const ParsedJson usual = engram_command(rollout).json();
  const ParsedJson other = engram_command(rollout + kMujoco).json();
  CHECK_FALSE(usual.contains("physics"));
  CHECK(other["physics"] == "mujoco");
  CHECK(other["mujoco_version"] == mj_versionString());
  CHECK(other["hash"] != usual["hash"]);

  const std::string verify = "verify " + id + " --steps 2 --obs state --json";
  const ParsedJson rows = engram_command(verify + kMujoco).json();
  CHECK(rows[0]["different"] == 0);
  CHECK(rows[0]["fingerprint"] != engram_command(verify).json()[0]["fingerprint"]);

  const ParsedJson probe =
      engram_command("probe " + id + " --probes twins --episodes 2 --json" + kMujoco).json();
  CHECK(probe["settings"]["physics"] == "mujoco");
  CHECK(engram_command("bench reset --rounds 1 --num-envs 2 --json" + std::string(kMujoco)).code ==
        0);
  require_refusal("bench reset --physics bullet", 2, "engram|mujoco allowed");
  if (kSanitized) return;  // the bounds are of the ordinary heap
  const ParsedJson soak =
      engram_command("soak " + id + " --env-steps 600 --cycles 40 --max-drift 1000 --json" +
                     kMujoco)
          .json();
  CHECK(soak["passed"] == true);
}

}  // namespace engram::test
