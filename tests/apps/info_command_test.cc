#include <mujoco/mujoco.h>

#include <catch2/catch.hpp>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "protocol/make/make.h"
#include "tests/apps/command.h"
#include "tests/env_helpers.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor9-VLA-v0";

// Sum of the widths of a layout, whose offsets must follow from them.
int checked_width(const ParsedJson& layout) {
  int offset = 0;
  for (const ParsedJson& field : layout) {
    CHECK(field["offset"] == offset);
    offset += field["width"].get<int>();
  }
  return offset;
}

}  // namespace

TEST_CASE("info: agrees with the library", "[apps]") {
  const ParsedJson task = engram_command(std::string("info --json ") + kId).json();
  const auto batch = make(kId);
  CHECK(task["id"] == kId);
  CHECK(task["horizon"] == batch->info().horizon);
  CHECK(task["chance"].get<double>() == Approx(1.0 / 9));
  CHECK(task["state_dim"] == batch->state_dim());
  CHECK(checked_width(task["state_fields"]) == batch->state_dim());
  CHECK(checked_width(task["proprio"]) == 7);
  CHECK(task["action_spaces"].size() == static_cast<std::size_t>(kControlModes));
  CHECK(task["action_spaces"]["pd_ee_delta_pose"]["dim"] == 7);
  CHECK(task["action_spaces"]["pd_ee_delta_pose"]["low"] == std::vector<double>(7, -1));
  CHECK(task["draws"].size() == Queries(*batch).random_variables().size());
  CHECK(task["draws"][1]["name"] == "target");
  CHECK(task["outputs"].size() == columns_of(*batch).size());
  std::set<std::string> privileged;
  for (const auto& output : task["outputs"]) {
    if (output["privileged"].get<bool>()) privileged.insert(output["name"].get<std::string>());
  }
  CHECK(privileged == std::set<std::string>{"observation", "oracle_info", "obj_to_goal_pos",
                                            "is_obj_placed", "reward_dict"});
  CHECK(task["props"].size() == batch->physics_model().props().size());
  CHECK(task["constants"]["COLORS"] == 9);
  CHECK(task["phases"].size() == batch->info().phases.size());
  CHECK(task["paraphrases"].size() >= 10);
  for (const char* key : {"family", "split", "memory_type", "canonical", "instruction",
                          "termination", "reward_terms", "candidates"}) {
    CHECK(task.contains(key));
  }
}

TEST_CASE("info: text output", "[apps]") {
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

}  // namespace engram::test
