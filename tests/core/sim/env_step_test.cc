#include "core/sim/env_step.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "core/sim/state_transfer.h"
#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

TEST_CASE("A woken prop takes its place among the awake and brings its state along", "[env_step]") {
  const test::MixedColumns columns;
  const PhysicsModel& model = test::mixed_model();
  StepWorkspace workspace(model);
  RobotBounds::Clearance clearance;
  EnvStep step(model, columns.state, 0, workspace, clearance, nullptr);
  StateTransfer(step).begin(true);
  REQUIRE(step.awake() == std::vector<int>{test::kCube0});
  columns.state.prop_qvel_of(0, test::kBall)[1] = 0.25;
  step.wake(test::kBall);
  CHECK(step.awake() == std::vector<int>{test::kCube0, test::kBall});
  CHECK(step.is_awake(test::kBall));
  CHECK_FALSE(step.is_asleep(test::kBall));
  CHECK(workspace.motion[test::kBall].center.x() == 0.1);
  CHECK(workspace.motion[test::kBall].linear.y() == 0.25);
  CHECK_FALSE(step.is_moving(test::kBox));
}

TEST_CASE("No point of a prop is faster than its bound", "[env_step]") {
  const test::MixedColumns columns;
  const PhysicsModel& model = test::mixed_model();
  StepWorkspace workspace(model);
  RobotBounds::Clearance clearance;
  EnvStep step(model, columns.state, 0, workspace, clearance, nullptr);
  StateTransfer(step).begin(true);
  FreeBodyState& motion = workspace.motion[test::kCube0];
  motion.linear = {0.3, 0, 0.4};
  motion.angular = {0, 2, 0};
  const Vec3 corner = Vec3::Constant(0.02);
  CHECK(step.prop_speed(test::kCube0) >= (motion.linear + motion.angular.cross(corner)).norm());
  CHECK(step.prop_speed(test::kCube0) == Approx(0.5 + 2 * 0.02 * std::sqrt(3.0)));
}

}  // namespace
}  // namespace engram
