// Mass matrix (CRBA) and bias forces (RNEA) against MuJoCo's.
#include "core/robot/robot_dynamics.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/scene/mujoco_handle.h"
#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("Mass matrix and bias forces are MuJoCo's", "[physics]") {
  const mjModel& model = physics().robot();
  const DataPtr data = make_data(model);
  std::vector<mjtNum> expected(static_cast<std::size_t>(model.nv * model.nv));
  double worst = 0;
  for (const Robot& robot : random_robots(256)) {
    std::copy(robot.q.begin(), robot.q.end(), data->qpos);
    std::copy(robot.v.begin(), robot.v.end(), data->qvel);
    mj_fwdPosition(&model, data.get());
    mj_comVel(&model, data.get());
    mj_rne(&model, data.get(), 0, data->qfrc_bias);
    for (int i = 0; i < model.nv; ++i) {  // columns, which the symmetry makes rows
      std::vector<mjtNum> unit(static_cast<std::size_t>(model.nv));
      unit[static_cast<std::size_t>(i)] = 1;
      mj_mulM(&model, data.get(), expected.data() + i * model.nv, unit.data());
    }

    const JointsOf<double> q = row_of(robot.q);
    LinkPoses<double> links;
    link_poses(physics().robot_model(), q, links);
    const RobotDynamics<double> dynamics(physics().robot_model(), q, links);
    JointMatrixOf<double> mass;
    dynamics.mass_matrix(mass);
    JointsOf<double> bias;
    dynamics.bias_force(row_of(robot.v), bias);
    for (int i = 0; i < kRobotJoints; ++i) {
      worst = std::max(worst, std::abs(bias[i] - data->qfrc_bias[i]));
      for (int k = 0; k < kRobotJoints; ++k) {
        const mjtNum theirs = expected[static_cast<std::size_t>(i * model.nv + k)];
        worst = std::max(worst, std::abs(mass[i][k] - theirs));
      }
    }
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("Inverting a mass matrix by Gauss-Jordan elimination gives its inverse", "[physics]") {
  const Robot robot = random_robots(1).front();
  const JointsOf<double> q = row_of(robot.q);
  LinkPoses<double> links;
  link_poses(physics().robot_model(), q, links);
  const RobotDynamics<double> dynamics(physics().robot_model(), q, links);
  JointMatrixOf<double> mass;
  dynamics.mass_matrix(mass);
  JointMatrixOf<double> inverse = mass;
  invert(inverse);
  for (int i = 0; i < kRobotJoints; ++i) {
    for (int k = 0; k < kRobotJoints; ++k) {
      double sum = 0;
      for (int j = 0; j < kRobotJoints; ++j) sum += mass[i][j] * inverse[j][k];
      CHECK(sum == Approx(i == k ? 1 : 0).margin(1e-9));
    }
  }
}

}  // namespace
}  // namespace engram::test
