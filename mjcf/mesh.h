// Props that are the convex hull of points.
#pragma once

#include <span>
#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// A solid of density 1000 kg/m^3 with the points' hull, resting on the table.
Prop mesh(const std::string& name, std::span<const Vec3> points, const Rgba& rgba);

}  // namespace engram::mjcf
