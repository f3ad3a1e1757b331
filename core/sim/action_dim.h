// Width of actions, for those who have no batch.
#pragma once

#include "core/sim/control_mode.h"

namespace engram {

// Components of an action in that mode, the gripper's included.
int action_dim(ControlMode mode);

}  // namespace engram
