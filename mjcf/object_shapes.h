// The nine procedural shapes of the Remember and Find-Imposter tasks. See docs/tasks/remember.md.
#pragma once

#include <string>
#include <string_view>

#include "mjcf/prop.h"

namespace engram::mjcf {

using engram::ObjectShape;
inline constexpr int kObjectShapeCount = static_cast<int>(kObjectShapeNames.size());
// The length from which all sizes of a shape follow, m: half the side of its cube.
inline constexpr double kShapeScale = 0.02;

// Name in the original benchmark: "cube", "pyramide", "t_shape", ...
std::string_view shape_name(ObjectShape shape);

// Height of the body's origin at which the lowest geom touches the table.
double resting_height(ObjectShape shape);

// A prop with all geoms of a shape, upright at the resting height. All of them count for mass
// and inertia, whether they collide or not.
Prop shape_prop(const std::string& name, ObjectShape shape, const Rgba& rgba,
                double scale = kShapeScale);

}  // namespace engram::mjcf
