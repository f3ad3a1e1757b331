// What the drives of the robot's joints follow during a control step.
#pragma once

#include <array>

#include "core/robot/joints.h"

namespace engram {

using JointArray = std::array<double, kRobotJoints>;

// What the drives of the nine joints follow during one control step.
struct Drive {
  JointArray target{};                        // rad, m
  std::array<double, kArmJoints> velocity{};  // rad/s, added through the damping
  bool velocity_mode = false;                 // arm: no stiffness, velocity target only
};

}  // namespace engram
