// Props of a scene as one drawn episode has them.
#pragma once

#include <vector>

#include "core/task/drawn_scene.h"
#include "mjcf/prop.h"

namespace engram::mjcf {

// Returns the props at their drawn poses and in their drawn colours. Hidden ones are parked side by
// side below the ground, and nothing of them collides.
std::vector<Prop> drawn_props(const std::vector<Prop>& props, const DrawnScene& drawn);

}  // namespace engram::mjcf
