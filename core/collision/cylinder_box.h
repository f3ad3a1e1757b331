// Contact points of a cylinder and a box by the separating axis test and clipping. The round side
// is smooth: it touches in the ends of a line, so cylinders roll; caps touch in up to four points.
#pragma once

#include "core/collision/box_box.h"

namespace engram {

struct CylinderPose {
  double radius = 0;       // m
  double half_height = 0;  // m
  Frame frame;             // world; z is the axis
};

// Points on the box, with normals from the box to the cylinder, whose gap is below `reach`.
ContactPoints cylinder_box(const CylinderPose& cylinder, const BoxPose& box, double reach);

// Lower bound of the distance of a cylinder and a box, m: the gap along the face normal of either
// that separates them most; below zero if none does.
double cylinder_box_separation(const CylinderPose& cylinder, const BoxPose& box);

}  // namespace engram
