// The drives of the robot's joints: what they follow during a control step, and with what force.
#pragma once

#include <mujoco/mujoco.h>

#include <array>

#include "core/physics/arm.h"

namespace engram {

// force = clamp(stiffness (target - q) - damping qvel, -limit, limit)
struct DriveLaw {
  double stiffness = 0;  // N m/rad, N/m
  double damping = 0;    // N m s/rad, N s/m; taken implicitly (scene_model.cc)
  double limit = 0;      // N m, N
};

// What the drives of the nine joints follow during one control step.
struct Drive {
  std::array<double, kRobotJoints> target{};  // rad, m
  std::array<double, kArmJoints> velocity{};  // rad/s, added through the damping
  bool velocity_mode = false;                 // arm: no stiffness, velocity target only
};

// Sets the controls of a scene's nine motors to what the drive law gives at the present state.
void apply_drive(const DriveLaw& law, const Drive& drive, mjData& data);

}  // namespace engram
