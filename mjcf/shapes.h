// The nine procedural shapes of the Remember and Find-Imposter tasks (remember 5).
#pragma once

#include <string>
#include <string_view>

#include "mjcf/prop.h"

namespace engram::mjcf {

// In the order of the shape families' keys (remember 3.2).
enum class ObjectShape {
  kCube,
  kSphere,
  kCylinder,
  kCross,
  kTorus,
  kStar,
  kPyramide,
  kTShape,
  kCrescent,
};
inline constexpr int kObjectShapeCount = 9;

// As the specification spells it: "cube", "pyramide", "t_shape", ...
std::string_view shape_name(ObjectShape shape);

// Height of the body's origin at which the lowest primitive touches the table (remember 5.3).
double resting_height(ObjectShape shape);

// A prop with all primitives of remember 5.2, upright at the resting height. Mass and inertia are
// those of remember 5.3: every primitive counts, whether it collides or not.
Prop shape_prop(const std::string& name, ObjectShape shape, const Rgba& rgba);

}  // namespace engram::mjcf
