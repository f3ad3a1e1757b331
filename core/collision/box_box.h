// Contact points of two boxes by the separating axis test over face normals and face clipping, in
// the order and with the thresholds of the original's solver, PhysX.
#pragma once

#include "core/collision/contact_point.h"
#include "core/math/frame.h"

namespace engram {

struct BoxPose {
  Vec3 half;    // half extents, m
  Frame frame;  // world
};

// Points on `b`, up to four, whose gap is below `reach`. Only the six face normals are candidates
// for the contact normal, so boxes that touch with edges have points, too. None if the boxes are
// farther apart, or if nothing is left of the clipped face.
ContactPoints box_box(const BoxPose& a, const BoxPose& b, double reach);

// Lower bound of the distance of two boxes, m: the gap along the face normal that separates them
// most; below zero if none does.
double box_separation(const BoxPose& a, const BoxPose& b);

}  // namespace engram
