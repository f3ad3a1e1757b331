// The robot's constants as they are read from a compiled model.
#include "core/scene/robot_model_loader.h"

#include <catch2/catch.hpp>

#include "core/scene/mujoco_handle.h"
#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("Links have the masses of the bodies that they carry", "[physics]") {
  const mjModel& model = physics().robot();
  const RobotModel robot = load_robot_model(model);
  double mass = 0;
  for (const RobotModel::Link& link : robot.links) mass += link.mass;
  for (const RobotModel::Link& finger : robot.fingers) mass += finger.mass;
  double moving = 0;
  for (int body = 1; body < model.nbody; ++body) {
    int ancestor = body;
    while (ancestor > 0 && model.body_jntnum[ancestor] == 0) {
      ancestor = model.body_parentid[ancestor];
    }
    if (ancestor > 0) moving += model.body_mass[body];
  }
  CHECK(mass == Approx(moving));
  CHECK(robot.fingers[0].mass == Approx(robot.fingers[1].mass));
}

TEST_CASE("Fingers open in opposite directions", "[physics]") {
  const RobotModel robot = load_robot_model(physics().robot());
  for (int k = 0; k < 3; ++k) {
    CHECK(robot.finger_axis[0][k] == Approx(-robot.finger_axis[1][k]).margin(1e-12));
  }
}

TEST_CASE("A robot of another build is refused", "[physics]") {
  const ModelPtr empty = compile_model("<mujoco><worldbody/></mujoco>");
  CHECK_THROWS_WITH(load_robot_model(*empty), Catch::Contains("seven hinges"));
}

}  // namespace
}  // namespace engram::test
