// Contact points of two convex hulls by the separating axis test over face normals and pairs of
// edges, and face clipping.
#pragma once

#include "core/collision/contact_point.h"
#include "core/math/convex_hull.h"
#include "core/math/frame.h"

namespace engram {

struct HullPose {
  const ConvexHull& hull;
  Frame frame;  // world
};

// Points on `b`, up to four, whose gap is below `reach`; one where edges cross. None if the hulls
// are farther apart.
ContactPoints hull_hull(const HullPose& a, const HullPose& b, double reach);

// Lower bound of the distance of two hulls, m: the gap along the face normal that separates them
// most; below zero if none does.
double hull_separation(const HullPose& a, const HullPose& b);

}  // namespace engram
