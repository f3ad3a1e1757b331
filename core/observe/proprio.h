// Layout of proprioception.
#pragma once

#include <vector>

#include "core/base/field.h"

namespace engram {

// Numbers of a row: TCP pose and gripper opening, or with joint_proprio the arm's joint angles and
// the opening.
constexpr int proprio_dim(bool joint_proprio) { return joint_proprio ? 8 : 7; }

// Parts of the proprioception.
std::vector<Field> proprio_fields(bool joint_proprio);

}  // namespace engram
