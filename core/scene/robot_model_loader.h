// Reads the robot's constants from a compiled model.
#pragma once

#include <mujoco/mujoco.h>

#include "core/robot/robot_model.h"

namespace engram {

// All but `lever_arms`. Throws Error if the robot is not of that structure.
RobotModel load_robot_model(const mjModel& model);

}  // namespace engram
