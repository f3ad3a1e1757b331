// Geoms that are the convex hull of points.
#pragma once

#include <span>
#include <vector>

#include "core/math/convex_hull.h"
#include "mjcf/prop.h"

namespace engram::mjcf {

// The convex hull of points as a geom (ConvexHull::kMaxCorners). Throws Error (kInvalidArgument)
// if they are flat.
Geom mesh_geom(std::span<const Vec3> points);

// The hull of a mesh geom, and its triangles, counter-clockwise seen from outside.
ConvexHull hull_of(const Geom& mesh);
std::vector<int> triangles_of(const ConvexHull& hull);

}  // namespace engram::mjcf
