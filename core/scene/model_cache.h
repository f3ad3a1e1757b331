// Cache of compiled scenes, shared by all batches of the process that run the same task.
#pragma once

#include <memory>

#include "core/scene/physics_model.h"

namespace engram {

// Returns the model of a scene: one that is in use already, or a new one. Compilation takes tens of
// milliseconds, a cache hit less than one. Thread-safe. Throws Error as PhysicsModel does.
std::shared_ptr<const PhysicsModel> cached_model(const SceneSpec& source);

}  // namespace engram
