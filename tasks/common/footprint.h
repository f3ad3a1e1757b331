// Footprints of objects on the table, and the clearance between two of them.
#pragma once

#include <vector>

#include "mjcf/prop.h"
#include "tasks/common/layout.h"

namespace engram::tasks {

// Part of the table that one primitive covers: a rectangle, or a disc where `half` is zero,
// each widened by `radius`.
struct FootprintPart {
  Vec2 center = Vec2::Zero();
  Vec2 half = Vec2::Zero();  // m
  double cosine = 1;         // of the rectangle's yaw
  double sine = 0;
  double radius = 0;  // m
};

// A prop seen from above, about its origin, in its nominal orientation.
struct Footprint {
  std::vector<FootprintPart> parts;
  Vec2 center = Vec2::Zero();  // of a circle around all parts
  double radius = 0;
};

// Throws Error unless boxes stand on a face and cylinders on an end: all that tables of objects
// here have.
Footprint footprint_of(const mjcf::Prop& prop);

// Gap between two parts, or minus the depth of their overlap.
double part_clearance(const FootprintPart& first, const FootprintPart& second, const Vec2& offset);

// Smallest gap between parts of two objects, the second one's origin at `offset` from the first
// one's. Exact where it is below kMinClearance of overlap_guard.h, else possibly too small, yet
// never below that.
double clearance(const Footprint& first, const Footprint& second, const Vec2& offset);

}  // namespace engram::tasks
