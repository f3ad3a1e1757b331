// Lower bounds of distances, which decide when sleeping props wake: sphere against shape, and
// separating axis tests of bounding boxes.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <span>

#include "core/scene/collision_scene.h"

namespace engram {

// Farther than anything in a scene.
inline constexpr double kFarAway = 1e9;  // m

// A lower bound of the distance between a sphere and a shape at this pose (world), m. If it is
// above zero, they do not touch. If it is not, they touch; for shapes other than boxes, capsules
// and spheres, they may.
double sphere_clearance(const CollisionShape& shape, const Frame& frame,
                        const Eigen::Vector3d& center, double radius);

// All points within `radius` of a box: contains a geom, tightly if it is a box, a sphere or a
// capsule.
struct RoundedBox {
  Frame frame;  // in the body's
  Eigen::Vector3d half = Eigen::Vector3d::Zero();
  double radius = 0;

  // Radius of the bounding sphere.
  double bounding_radius() const { return half.norm() + radius; }
};
RoundedBox enclose_geom(const mjModel& model, int geom);

// A lower bound of the distance between the parts of two bodies, less `gap`, m. If it is above
// zero, no part of one body is within `gap` of a part of the other.
double parts_clearance(double gap, std::span<const RoundedBox> a, const Frame& frame_a,
                       std::span<const RoundedBox> b, const Frame& frame_b);

}  // namespace engram
