// Contact points of pairs of shapes: box_box with persistent manifolds for boxes, cylinder_box,
// hull_hull for meshes with one another and with boxes, MuJoCo's collision functions for all
// others.
#pragma once

#include <array>
#include <vector>

#include "core/collision/manifold.h"
#include "core/scene/collision_scene.h"
#include "core/scene/mujoco_handle.h"
#include "core/scene/mujoco_versions.h"

namespace engram {

// Contacts exist where the gap is below this.
inline constexpr double kContactReach = 0.04;  // m

class NarrowPhase {
 public:
  // Working memory of one thread. Both must outlive this object.
  NarrowPhase(const mjModel& model, const CollisionScene& scene);

  // Contact points of a pair at these poses of its shapes (world), with all those whose gap is
  // below `reach`. `pair` holds what was found before. Call it within a MujocoScope.
  ContactPoints find(int shape_pair, const Frame& a, const Frame& b, double reach,
                     ContactPair& pair);
  // Lower bound of the gaps of all points that `find` has, m, for a fraction of its cost; minus
  // infinity for pairs that MuJoCo's functions collide.
  double separation(int shape_pair, const Frame& a, const Frame& b) const;

 private:
  const Eigen::Vector4d& quat_of(const Mat3& axes);
  ContactPoints find_boxes(int shape_pair, const Frame& a, const Frame& b, ContactPair& pair);
  // MuJoCo's points.
  ContactPoints collide(const ShapePair& pair, const Frame& a, const Frame& b, double reach);
  void pose(int shape, const Frame& frame);

  const mjModel& model_;
  const CollisionScene& scene_;
  DataPtr data_;
  std::vector<ManifoldLimits> limits_;  // of each shape pair
  // Axes, of which many pairs have the same, and their quaternions: the last ones asked for.
  struct KnownQuat {
    Mat3 axes = Mat3::Identity();
    Eigen::Vector4d quat{1, 0, 0, 0};
  };
  std::array<KnownQuat, 4> quats_;
  std::size_t oldest_quat_ = 0;
  std::vector<MujocoContact> found_;
};

}  // namespace engram
