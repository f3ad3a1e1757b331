// From a compiled model to what the robot's kernels know.
#pragma once

#include <mujoco/mujoco.h>

#include "core/physics/robot_chain.h"

namespace engram {

// All but `arms`. Throws Error if the robot is not of that structure.
RobotChain read_robot_chain(const mjModel& model);

}  // namespace engram
