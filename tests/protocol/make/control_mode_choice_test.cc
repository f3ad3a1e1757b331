#include "protocol/make/control_mode_choice.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram {
namespace {

TEST_CASE("Without a control mode, a run has that of its tasks", "[control_mode]") {
  const RegistryEntry* const vla = &require_entry("RememberColor3-VLA-v0");
  const RegistryEntry* const rl = &require_entry("RememberColor3-v0");
  const RegistryEntry* const other = &require_entry("RememberColor5-v0");
  const RegistryEntry* both[] = {rl, other};
  CHECK(common_control_mode({}, {&vla, 1}) == ControlMode::kPdEeDeltaPose);
  CHECK(common_control_mode({}, both) == ControlMode::kPdJointDeltaPos);
  CHECK(common_control_mode({}, {}) == ControlMode::kPdEeDeltaPose);
  const RegistryEntry* mixed[] = {vla, rl};
  CHECK(common_control_mode(ControlMode::kPdJointPos, mixed) == ControlMode::kPdJointPos);
  CHECK_THROWS_WITH(common_control_mode({}, mixed),
                    "no control mode given, and pd_ee_delta_pose is that of RememberColor3-VLA-v0, "
                    "pd_joint_delta_pos that of RememberColor3-v0; one for all tasks needed");
}

}  // namespace
}  // namespace engram
