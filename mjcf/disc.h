// A flat disc that lies on the table and carries cubes.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// The body's x axis is the disc's axis; poses in observations are of that body.
inline constexpr Quat kDiscQuat{0.7071067811865476, 0, 0.7071067811865476, 0};

// Moved by the task only. It looks round and collides as the square around it, on which cubes can
// rest. The square is as high as the disc.
Prop disc(const std::string& name, double radius, double half_height, const Rgba& rgba);

}  // namespace engram::mjcf
