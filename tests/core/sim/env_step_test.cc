#include "core/sim/env_step.h"

#include <catch2/catch.hpp>

#include "core/sim/scene_binding.h"
#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

TEST_CASE("A woken prop counts in the smallest scene and brings its state along", "[env_step]") {
  const test::MixedColumns columns;
  const PhysicsModel& model = test::mixed_model();
  StepWorkspace workspace(model);
  SceneWorkspace scenes(model);
  RobotBounds::Clearance clearance;
  EnvStep step(model, columns.state, 0, workspace, clearance, nullptr);
  SceneBinding(step, scenes).begin(true);
  REQUIRE(step.num_awake == 1);
  const int before = step.smallest_scene(false);
  columns.state.prop_qvel_of(0, test::kBall)[1] = 0.25;
  step.wake(test::kBall);
  CHECK(step.num_awake == 2);
  CHECK(step.is_awake(test::kBall));
  CHECK(workspace.slot[test::kBall] == EnvStep::kNoSlot);
  CHECK(workspace.motion[test::kBall].qpos[0] == 0.1);
  CHECK(workspace.motion[test::kBall].qvel[1] == 0.25);
  CHECK(step.smallest_scene(false) > before);
  CHECK_FALSE(step.is_moving(test::kBox));
}

}  // namespace
}  // namespace engram
