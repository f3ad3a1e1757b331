// What `list`, `info`, `doctor` and `bench` tell.
#include <mujoco/mujoco.h>

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/env/queries.h"
#include "protocol/batch/make.h"
#include "tests/apps/command.h"
#include "tests/sanitizers.h"

namespace engram::tests {
namespace {

constexpr const char* kId = "RememberColor9-VLA-v0";

// Sum of the widths of a layout, whose offsets must follow from them.
int checked_width(const Json& layout) {
  int offset = 0;
  for (const Json& field : layout) {
    CHECK(field["offset"] == offset);
    offset += field["width"].get<int>();
  }
  return offset;
}

}  // namespace

TEST_CASE("list: the whole registry, in order", "[apps]") {
  const Json tasks = engram_command("list --json").json();
  REQUIRE(tasks.size() == registry().size());
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    const RegistryEntry& entry = registry()[i];
    const Json& task = tasks[i];
    CHECK(keys_of(task) == std::vector<std::string>{"id", "family", "split", "memory_type",
                                                    "horizon", "canonical", "instruction",
                                                    "action_dim", "state_dim", "candidates"});
    CHECK(task["id"] == entry.id);
    CHECK(task["horizon"] == entry.horizon);
    CHECK(task["action_dim"] == 7);
    const auto env = make(entry.id);
    CHECK(task["state_dim"] == env->state_dim());
    CHECK(task["candidates"] == env->info().candidates);
  }
}

TEST_CASE("list: filters", "[apps]") {
  const Json tasks = engram_command("list --split short --family RememberColor --json").json();
  REQUIRE(tasks.size() == 3);
  for (const Json& task : tasks) CHECK(task["family"] == "RememberColor");
  CHECK(tasks[2]["candidates"] == 9);
  const CommandResult table = engram_command("list --split long");
  CHECK(table.code == 0);
  CHECK_THAT(table.out, Catch::Contains("22 tasks"));
}

TEST_CASE("info: agrees with the library", "[apps]") {
  const Json task = engram_command(std::string("info --json ") + kId).json();
  const auto env = make(kId);
  CHECK(task["id"] == kId);
  CHECK(task["horizon"] == env->info().horizon);
  CHECK(task["chance"].get<double>() == Approx(1.0 / 9));
  CHECK(task["state_dim"] == env->state_dim());
  CHECK(checked_width(task["state_fields"]) == env->state_dim());
  CHECK(checked_width(task["proprio"]) == 7);
  CHECK(task["action_spaces"].size() == static_cast<std::size_t>(kControlModes));
  CHECK(task["action_spaces"]["pd_ee_delta_pose"]["dim"] == 7);
  CHECK(task["action_spaces"]["pd_ee_delta_pose"]["low"] == std::vector<double>(7, -1));
  CHECK(task["draws"].size() == Queries(*env).random_variables().size());
  CHECK(task["draws"][1]["name"] == "target");
  CHECK(task["outputs"].size() == env->outputs().size());
  std::set<std::string> privileged;
  for (const auto& output : task["outputs"]) {
    if (output["privileged"].get<bool>()) privileged.insert(output["name"].get<std::string>());
  }
  CHECK(privileged == std::set<std::string>{"observation", "oracle_info", "obj_to_goal_pos",
                                            "is_obj_placed", "reward_dict"});
  CHECK(task["props"].size() == env->physics_model().props().size());
  CHECK(task["constants"]["COLORS"] == 9);
  CHECK(task["phases"].size() == env->info().phases.size());
  for (const char* key : {"family", "split", "memory_type", "canonical", "instruction",
                          "termination", "reward_terms", "candidates"}) {
    CHECK(task.contains(key));
  }
}

TEST_CASE("info: in words", "[apps]") {
  const CommandResult result = engram_command(std::string("info ") + kId);
  CHECK(result.code == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, Catch::Contains("Phases") && Catch::Contains("cue_steps") &&
                             Catch::Contains("Props") && Catch::Contains("GOAL_THRESH"));
}

TEST_CASE("info: the MJCF dump is a scene that MuJoCo loads", "[apps]") {
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "scene.xml").string();
  const CommandResult saved = engram_command(std::string("info ") + kId + " --mjcf " + file);
  REQUIRE(saved.code == 0);
  const CommandResult printed = engram_command(std::string("info ") + kId + " --mjcf -");
  REQUIRE(printed.code == 0);
  CHECK(printed.out == read_file(file));

  char message[1000] = "";
  const ModelPtr model(mj_loadXML(file.c_str(), nullptr, message, sizeof message));
  INFO(message);
  REQUIRE(model != nullptr);
  CHECK(mj_name2id(model.get(), mjOBJ_BODY, "cube_8") >= 0);
}

TEST_CASE("doctor: versions, machine and memory", "[apps]") {
  const Json facts = engram_command("doctor --json").json();
  CHECK(facts["version"] == version());
  CHECK(facts["mujoco_runtime"] == facts["mujoco_compiled"]);
  CHECK(facts["threads"].get<int>() >= 1);
  CHECK(facts["bytes_per_env"].get<double>() > 0);
  // Sanitizers keep freed memory resident.
  if (!test::kSanitized) CHECK(facts["resident_bytes_per_env"].get<double>() > 0);
  CHECK(facts["egl"].get<std::string>().size() > 0);
  CHECK(facts["egl_available"].get<bool>() == (facts["egl_renderer"] != ""));
  CHECK(engram_command("doctor").code == 0);
}

TEST_CASE("bench: rows of a suite", "[apps]") {
  const Json rows = engram_command("bench create --rounds 1 --json").json();
  REQUIRE(!rows.empty());
  for (const Json& row : rows) {
    CHECK(keys_of(row) == std::vector<std::string>{"name", "value", "unit", "baseline",
                                                   "baseline_value", "ratio", "rounds"});
  }
}

}  // namespace engram::tests
