// The robot's joints: their number, what their drives follow, and the constants of their motion.
#pragma once

#include <array>

namespace engram {

inline constexpr int kArmJoints = 7;
inline constexpr int kFingers = 2;
inline constexpr int kRobotJoints = kArmJoints + kFingers;  // qpos order: arm, left, right finger

using JointArray = std::array<double, kRobotJoints>;

// Targets of the nine drives during one control step.
struct DriveTarget {
  JointArray qpos{};                      // rad, m
  std::array<double, kArmJoints> qvel{};  // rad/s, added through the damping
  bool velocity_mode = false;             // arm: no stiffness, velocity target only
};

// force = stiffness (target - q) + damping (target velocity - qvel), within the limit. Taken
// implicitly.
struct DriveParams {
  double stiffness = 0;  // N m/rad, N/m
  double damping = 0;    // N m s/rad, N s/m
  double limit = 0;      // N m, N
};

// Constants of all substeps.
struct RobotParams {
  DriveParams drive;
  double lower[kRobotJoints] = {};  // joint limits, rad, m
  double upper[kRobotJoints] = {};  // rad, m
  double timestep = 0;              // of a substep, s
};

}  // namespace engram
