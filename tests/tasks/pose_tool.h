// Puts the robot's tool where a test wants it.
#pragma once

#include <algorithm>

#include "tasks/common/tcp_servo.h"
#include "tests/env_helpers.h"

namespace engram::test {

// Joint angles that bring the TCP there, pointing down, and no velocity. Without physics
// (BatchOptions::substeps 0) the tool stays there, and the next step measures it there.
inline void pose_tool(const Batch& batch, const Eigen::Vector3d& pos, int index = 0) {
  constexpr double kLongest = 0.1;  // step, m and rad: longer ones may lead anywhere
  const Arm& arm = batch.physics_model().arm();
  const State& state = batch.state();
  double* q = state.qpos.row(index);
  ArmJacobian jacobian;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = arm.forward(q, jacobian);
    Eigen::Matrix<double, 6, 1> twist;
    twist.head<3>() = pos - pose.pos;
    twist.tail<3>() = rotation_vector(tasks::kToolDown * pose.quat.conjugate());
    if (twist.norm() < 1e-13) break;
    if (twist.norm() > kLongest) twist *= kLongest / twist.norm();
    Eigen::Map<ArmVector>(q) += Arm::pseudo_inverse_step(jacobian, twist);
  }
  std::fill_n(state.qvel.row(index), kRobotJoints, 0.0);
}

// One step of an environment without physics, with the tool there.
inline void step_at(Batch& batch, const Eigen::Vector3d& pos) {
  pose_tool(batch, pos);
  step(batch, Policy::kZero);
}

}  // namespace engram::test
