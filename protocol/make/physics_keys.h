// Physics as results and data sets name them.
#pragma once

#include <string>

#include "core/batch/options.h"
#include "protocol/io/json.h"

namespace engram {

inline constexpr const char* kPhysicsKey = "physics";
inline constexpr const char* kMujocoVersionKey = "mujoco_version";

// The physics of a document, which older ones do not name: engram's own.
Json physics_in(const Json& document);
// MuJoCo's version where it is the physics; null for engram's own.
Json mujoco_version_of(Physics physics);
// "engram", or "mujoco 2.2.2".
std::string physics_text(const Json& document);

}  // namespace engram
