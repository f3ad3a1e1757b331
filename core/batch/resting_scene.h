// A drawn scene at rest, by MuJoCo's own step.
#pragma once

#include "core/scene/physics_model.h"
#include "core/task/task.h"

namespace engram {

// Returns the scene with its free props where they come to rest: balls and objects that hang in the
// air at an episode's begin lie on the table. What stands already keeps its pose to the bit.
DrawnScene resting_scene(const Task& task, const PhysicsModel& physics, const DrawnScene& drawn);

}  // namespace engram
