// Persistent contact manifold of two boxes: points are kept until one has slid away or the boxes
// have moved enough, as in PhysX. So normals do not flip from substep to substep.
#pragma once

#include "core/collision/box_box.h"
#include "core/collision/contact_pair.h"

namespace engram {

// Thresholds of one pair of boxes.
struct ManifoldLimits {
  double margin = 0;  // m; relative motion is measured in shares of it
  // Least dot products of a box's quaternions before and now, for its rotation to move its corners
  // by less than a share of the margin: by number of points.
  std::array<double, Manifold::kMaxPoints + 1> cosine_a{};
  std::array<double, Manifold::kMaxPoints + 1> cosine_b{};
};
ManifoldLimits manifold_limits(const Vec3& half_a, const Vec3& half_b);

// Unit quaternion (w, x, y, z) of axes, with w not below zero.
Eigen::Vector4d manifold_quat(const Mat3& axes);

// A box with the quaternion of its axes.
struct ManifoldBox {
  ManifoldBox(const BoxPose& box, const Eigen::Vector4d& its_quat) : pose(box), quat(its_quat) {}
  // NOLINTNEXTLINE(google-explicit-constructor): what is not given follows from the pose
  ManifoldBox(const BoxPose& box) : ManifoldBox(box, manifold_quat(box.frame.axes)) {}

  const BoxPose& pose;
  Eigen::Vector4d quat;
};

// Moves the points of `manifold` with the boxes and drops those that have slid away. True if it
// has to be found anew.
bool refresh_manifold(Manifold& manifold, const ManifoldBox& a, const ManifoldBox& b,
                      const ManifoldLimits& limits);
// Finds it anew, with points up to `reach` apart; empty if nothing is left of the clipped face.
void find_manifold(Manifold& manifold, const ManifoldBox& a, const ManifoldBox& b, double reach);

// The manifold's points whose gap is at most `reach`.
ContactPoints manifold_points(const Manifold& manifold, const BoxPose& a, const BoxPose& b,
                              double reach);

}  // namespace engram
