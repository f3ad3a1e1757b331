// Robots in random states, for tests of what moves them.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "core/math/random.h"
#include "core/robot/joint_rows.h"
#include "core/scene/physics_model.h"
#include "tasks/common/task_info.h"

namespace engram::test {

inline const PhysicsModel& physics() {
  static const PhysicsModel model(tasks::scene_source({}));
  return model;
}

struct Robot {
  JointArray q;
  JointArray v;
  DriveTarget drive;
  std::array<double, 6> displacement;
};

// Anywhere between the limits, often with fingers at theirs, fast and with far targets: drives and
// limits take part.
inline Robot random_robot(RandomStream& random) {
  const RobotParams& params = physics().robot_params();
  Robot robot;
  const bool open = random.uniform(0, 1) < 0.3;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    const bool finger = i >= kArmJoints;
    robot.q[i] =
        finger && open ? params.upper[i] : random.uniform(params.lower[i], params.upper[i]);
    robot.v[i] = finger ? random.uniform(-0.1, 0.1) : random.uniform(-2, 2);
    robot.drive.qpos[i] = robot.q[i] + random.uniform(-0.3, 0.3);
  }
  for (double& value : robot.displacement) value = random.uniform(-0.1, 0.1);
  return robot;
}

// Part of a drive's force that does not depend on the joint's motion, N m, N; see JointSolver.
inline double drive_bias_of(const Robot& robot, int joint) {
  return physics().robot_params().drive.stiffness *
         robot.drive.qpos[static_cast<std::size_t>(joint)];
}

inline std::vector<Robot> random_robots(int count) {
  RandomStream random(5, 0, 0);
  std::vector<Robot> robots;
  robots.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) robots.push_back(random_robot(random));
  return robots;
}

// The joints' entries, as kernels have them.
inline JointsOf<double> row_of(const JointArray& joints) {
  JointsOf<double> row;
  std::copy(joints.begin(), joints.end(), row.at);
  return row;
}

inline bool same_bits(const double* a, const double* b, int count) {
  return std::equal(a, a + count, b, [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

}  // namespace engram::test
