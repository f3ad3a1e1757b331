// One robot's substep: its effective mass, and motion at constant velocity.
#include "core/robot/robot_step.h"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

using Matrix9 = Eigen::Matrix<double, kRobotJoints, kRobotJoints>;

Matrix9 to_eigen(const JointMatrix& from) {
  Matrix9 matrix;
  for (int i = 0; i < kRobotJoints; ++i) {
    for (int k = 0; k < kRobotJoints; ++k) matrix(i, k) = from[i][k];
  }
  return matrix;
}

RobotStep step_of(const Robot& robot) {
  RobotStep step(physics().robot_params(), robot.drive);
  step.begin(physics().robot_model(), robot.q.data(), robot.v.data());
  return step;
}

TEST_CASE("The effective mass is that of the links and what drives add to it", "[physics]") {
  for (const Robot& robot : random_robots(32)) {
    RobotStep step = step_of(robot);
    step.run({});
    const Matrix9 mass = to_eigen(step.mass_matrix);
    const Matrix9 effective = to_eigen(step.effective_mass_matrix());
    CHECK((mass - mass.transpose()).norm() == 0);
    CHECK((effective - effective.transpose()).norm() < 1e-6 * effective.norm());
    // Drives resist, so nothing moves more easily than the links alone.
    const Eigen::SelfAdjointEigenSolver<Matrix9> added(0.5 * (effective + effective.transpose()) -
                                                       mass);
    CHECK(added.eigenvalues().minCoeff() > -1e-6 * effective.norm());
  }
}

TEST_CASE("At constant velocity a robot goes as far as the substep takes, and to its limits",
          "[physics]") {
  const RobotParams& params = physics().robot_params();
  Robot robot = random_robots(1).front();
  robot.q[3] = params.lower[3] + 1e-6;
  RobotStep step = step_of(robot);
  step.run({});
  JointArray velocity{};
  velocity[0] = 0.5;
  velocity[3] = -1;
  step.integrate_constant_velocity(velocity);
  CHECK(step.end_v() == velocity);
  CHECK(step.end_q()[0] == robot.q[0] + params.timestep * 0.5);
  CHECK(step.end_q()[3] == params.lower[3]);
}

TEST_CASE("A force on a joint pushes it", "[physics]") {
  const Robot robot = random_robots(1).front();
  RobotStep still = step_of(robot);
  RobotStep pushed = step_of(robot);
  still.run({});
  JointArray force{};
  force[0] = 50;
  pushed.run(force);
  CHECK(pushed.end_v()[0] > still.end_v()[0]);
}

TEST_CASE("A drive's bias is stiffness times target plus damping times target velocity",
          "[physics]") {
  const RobotParams& params = physics().robot_params();
  DriveTarget target;
  target.qpos = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  target.qvel[0] = 0.5;
  CHECK(drive_bias(params, target, 0) == params.drive.stiffness * 1 + params.drive.damping * 0.5);
  CHECK(drive_bias(params, target, 8) == params.drive.stiffness * 9);
  target.velocity_mode = true;
  CHECK(drive_bias(params, target, 0) == params.drive.damping * 0.5);
  CHECK(drive_bias(params, target, 8) == params.drive.stiffness * 9);  // fingers keep theirs
}

}  // namespace
}  // namespace engram::test
