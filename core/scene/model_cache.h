// Compiled scenes, shared by all batches of the process that run the same task.
#pragma once

#include <memory>

#include "core/scene/physics_model.h"

namespace engram {

// The model of a source: one that is in use already, or a new one. Compiling takes tens of
// milliseconds, finding less than one. May be called from several threads at once. Throws Error as
// PhysicsModel does.
std::shared_ptr<const PhysicsModel> cached_model(const SceneSpec& source);

}  // namespace engram
