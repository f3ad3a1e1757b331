// The drives of the robot's joints: what they follow during a control step, and by which law.
#pragma once

#include <array>

#include "core/physics/arm.h"

namespace engram {

using JointArray = std::array<double, kRobotJoints>;

// force = stiffness (target - q) + damping (target velocity - qvel), within the limit. Taken
// implicitly: see robot_step.h.
struct DriveLaw {
  double stiffness = 0;  // N m/rad, N/m
  double damping = 0;    // N m s/rad, N s/m
  double limit = 0;      // N m, N
};

// What the drives of the nine joints follow during one control step.
struct Drive {
  JointArray target{};                        // rad, m
  std::array<double, kArmJoints> velocity{};  // rad/s, added through the damping
  bool velocity_mode = false;                 // arm: no stiffness, velocity target only
};

}  // namespace engram
