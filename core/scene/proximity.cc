#include "core/scene/proximity.h"

#include <algorithm>
#include <cmath>

#include "core/math/eigen_types.h"

namespace engram {
namespace {

// Separating axis test of two boxes: how much farther apart than `gap` they are, along the axis
// that separates them most: a face normal, the cross product of two edges, or the line between
// their centres. `offset` and `rotation` place the second in the frame of the first.
double box_clearance(double gap, const RoundedBox& a, const RoundedBox& b, const Vec3& offset,
                     const Eigen::Matrix3d& rotation) {
  const Eigen::Matrix3d spread = (rotation.array().abs() + 1e-12).matrix();
  const double reach = a.radius + b.radius + gap;
  const Vec3 across_a = a.half + spread * b.half;
  const Vec3 across_b = b.half + spread.transpose() * a.half;
  const Vec3 seen_from_b = rotation.transpose() * offset;
  const double faces = std::max((offset.cwiseAbs() - across_a).maxCoeff(),
                                (seen_from_b.cwiseAbs() - across_b).maxCoeff()) -
                       reach;
  if (faces > 0) return faces;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3;
    const int i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3;
      const int j2 = (j + 2) % 3;
      // Times the sine of the angle between the edges.
      const double apart = std::abs(offset[i2] * rotation(i1, j) - offset[i1] * rotation(i2, j));
      const double across = a.half[i1] * spread(i2, j) + a.half[i2] * spread(i1, j) +
                            b.half[j1] * spread(i, j2) + b.half[j2] * spread(i, j1);
      if (apart > across + reach) return apart - across - reach;
    }
  }
  const double apart = offset.norm();
  const double across = offset.cwiseAbs().dot(a.half) + seen_from_b.cwiseAbs().dot(b.half);
  return apart > 0 ? apart - across / apart - reach - 1e-15 : -reach;
}

}  // namespace

double sphere_clearance(const CollisionShape& shape, const Frame& frame,
                        const Eigen::Vector3d& center, double radius) {
  const Vec3 offset = center - frame.pos;
  const double around = shape.bounding_radius + radius;
  const double squared = offset.squaredNorm();
  if (squared > around * around) return std::sqrt(squared) - around;

  const Vec3 local = frame.axes.transpose() * offset;
  switch (shape.type) {
    case mjGEOM_BOX:
      return (local - local.cwiseMin(shape.half).cwiseMax(-shape.half)).norm() - radius;
    case mjGEOM_CAPSULE: {
      const double along = std::clamp(local.z(), -shape.half[1], shape.half[1]);
      return (local - Vec3(0, 0, along)).norm() - shape.half[0] - radius;
    }
    default:
      return 0;  // inside the bounding sphere: take it as touching
  }
}

RoundedBox enclose_geom(const mjModel& model, int geom) {
  const mjtNum* size = model.geom_size + 3 * geom;
  RoundedBox box;
  box.frame = make_frame(model.geom_pos + 3 * geom, model.geom_quat + 4 * geom);
  switch (model.geom_type[geom]) {
    case mjGEOM_BOX:
    case mjGEOM_ELLIPSOID:
      box.half = Vec3(size[0], size[1], size[2]);
      break;
    case mjGEOM_CYLINDER:
      box.half = Vec3(size[0], size[0], size[1]);
      break;
    case mjGEOM_CAPSULE:
      box.half = Vec3(0, 0, size[1]);
      box.radius = size[0];
      break;
    case mjGEOM_MESH: {
      const int mesh = model.geom_dataid[geom];
      Eigen::AlignedBox3d bounds;
      for (const Vec3& vertex : mesh_vertices(model, mesh)) bounds.extend(vertex);
      box.half = bounds.sizes() / 2;
      box.frame.pos += box.frame.axes * bounds.center();
      break;
    }
    default:
      box.radius = model.geom_rbound[geom];
  }
  return box;
}

double parts_clearance(double gap, std::span<const RoundedBox> a, const Frame& frame_a,
                       std::span<const RoundedBox> b, const Frame& frame_b) {
  double least = kFarAway;
  for (const RoundedBox& first : a) {
    const Vec3 center = frame_a.pos + frame_a.axes * first.frame.pos;
    const Eigen::Matrix3d axes = frame_a.axes * first.frame.axes;
    const Eigen::Matrix3d turn = axes.transpose() * frame_b.axes;
    const double reach_of_first = first.bounding_radius();
    for (const RoundedBox& second : b) {
      const Vec3 apart = frame_b.pos + frame_b.axes * second.frame.pos - center;
      const double reach = reach_of_first + second.bounding_radius() + gap;
      const double squared = apart.squaredNorm();
      double clearance = 0;
      if (squared > reach * reach) {
        clearance = std::sqrt(squared) - reach;
      } else {
        clearance =
            box_clearance(gap, first, second, axes.transpose() * apart, turn * second.frame.axes);
      }
      if (clearance <= 0) return clearance;
      least = std::min(least, clearance);
    }
  }
  return least;
}

}  // namespace engram
