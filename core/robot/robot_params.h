// The numbers of the law by which the robot's joints move (joint_law.h).
#pragma once

#include "core/robot/joints.h"

namespace engram {

// force = stiffness (target - q) + damping (target velocity - qvel), within the limit. Taken
// implicitly.
struct DriveParams {
  double stiffness = 0;  // N m/rad, N/m
  double damping = 0;    // N m s/rad, N s/m
  double limit = 0;      // N m, N
};

// What is the same in every substep.
struct RobotParams {
  DriveParams drive;
  double lower[kRobotJoints] = {};  // joint limits, rad, m
  double upper[kRobotJoints] = {};  // rad, m
  double timestep = 0;              // of a substep, s
};

}  // namespace engram
