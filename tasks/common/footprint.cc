#include "tasks/common/footprint.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

#include "core/base/error.h"
#include "tasks/common/overlap_guard.h"

namespace engram::tasks {
namespace {

// Least cosine between an axis and the vertical for which the axis stands upright.
constexpr double kUprightCosine = 1 - 1e-9;

Eigen::Quaterniond quaternion(const mjcf::Quat& q) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

[[noreturn]] void refuse(const mjcf::Prop& prop) {
  throw Error(Error::kInternal, "no footprint for prop '" + prop.name +
                                    "': only spheres, standing cylinders and boxes have one");
}

bool is_upright(const Eigen::Matrix3d& rotation, Eigen::Index axis) {
  return std::abs(rotation(2, axis)) > kUprightCosine;
}

FootprintPart box_part(const mjcf::Prop& prop, const mjcf::Geom& box,
                       const Eigen::Matrix3d& rotation) {
  for (const Eigen::Index up : {2, 1, 0}) {
    if (!is_upright(rotation, up)) continue;
    const Eigen::Index along = (up + 1) % 3;
    const Eigen::Index across = (up + 2) % 3;
    const auto size = [&box](Eigen::Index axis) {
      return box.size[static_cast<std::size_t>(axis)];
    };
    return {Vec2::Zero(), {size(along), size(across)}, rotation(0, along), rotation(1, along), 0};
  }
  refuse(prop);
}

FootprintPart part_of(const mjcf::Prop& prop, const mjcf::Geom& geom) {
  const Eigen::Quaterniond body = quaternion(prop.quat);
  const Eigen::Matrix3d rotation = (body * quaternion(geom.quat)).toRotationMatrix();
  FootprintPart part;
  switch (geom.type) {
    case mjcf::GeomType::kBox:
      part = box_part(prop, geom, rotation);
      break;
    case mjcf::GeomType::kCylinder:
      if (!is_upright(rotation, 2)) refuse(prop);
      part.radius = geom.size[0];
      break;
    case mjcf::GeomType::kSphere:
      part.radius = geom.size[0];
      break;
    default:
      refuse(prop);
  }
  part.center = (body * Eigen::Vector3d(geom.pos[0], geom.pos[1], geom.pos[2])).head<2>();
  return part;
}

Vec2 to_frame(const FootprintPart& part, const Vec2& vector) {
  return {part.cosine * vector.x() + part.sine * vector.y(),
          part.cosine * vector.y() - part.sine * vector.x()};
}

Vec2 from_frame(const FootprintPart& part, const Vec2& vector) {
  return {part.cosine * vector.x() - part.sine * vector.y(),
          part.sine * vector.x() + part.cosine * vector.y()};
}

std::array<Vec2, 4> corners(const FootprintPart& part) {
  const Vec2 a = from_frame(part, part.half);
  const Vec2 b = from_frame(part, {part.half.x(), -part.half.y()});
  return {a, b, Vec2(-a), Vec2(-b)};
}

// Distance of a point from the rectangle, negative inside; both about the rectangle's centre.
double distance_from(const FootprintPart& part, const Vec2& point) {
  const Vec2 gap = to_frame(part, point).cwiseAbs() - part.half;
  if (gap.x() < 0 && gap.y() < 0) return gap.maxCoeff();
  return gap.cwiseMax(0.0).norm();
}

// Greatest gap between the projections of two rectangles onto the first one's axes.
double axis_gap(const FootprintPart& part, const FootprintPart& other, const Vec2& offset) {
  const Vec2 distance = to_frame(part, offset).cwiseAbs();
  Vec2 reach = Vec2::Zero();
  for (const Vec2& corner : corners(other)) {
    reach = reach.cwiseMax(to_frame(part, corner).cwiseAbs());
  }
  return (distance - part.half - reach).maxCoeff();
}

// Gap of two rectangles: the distance between the nearest points, one of which is a corner, or
// minus the overlap along the axis of least overlap.
double rectangle_clearance(const FootprintPart& first, const FootprintPart& second,
                           const Vec2& offset) {
  const double gap = std::max(axis_gap(first, second, offset), axis_gap(second, first, -offset));
  if (gap <= 0) return gap;
  double least = std::numeric_limits<double>::max();
  for (const Vec2& corner : corners(second)) {
    least = std::min(least, distance_from(first, offset + corner));
  }
  for (const Vec2& corner : corners(first)) {
    least = std::min(least, distance_from(second, corner - offset));
  }
  return least;
}

}  // namespace

Footprint footprint_of(const mjcf::Prop& prop) {
  Footprint footprint;
  for (const mjcf::Geom& geom : prop.geoms) {
    footprint.parts.push_back(part_of(prop, geom));
    footprint.center += footprint.parts.back().center;
  }
  footprint.center /= static_cast<double>(footprint.parts.size());
  for (const FootprintPart& part : footprint.parts) {
    const double reach = part.half.norm() + part.radius;
    footprint.radius = std::max(footprint.radius, (part.center - footprint.center).norm() + reach);
  }
  return footprint;
}

double part_clearance(const FootprintPart& first, const FootprintPart& second, const Vec2& offset) {
  const Vec2 between = offset + second.center - first.center;
  const bool discs = first.half.isZero() && second.half.isZero();
  const double gap = discs ? between.norm() : rectangle_clearance(first, second, between);
  return gap - first.radius - second.radius;
}

double clearance(const Footprint& first, const Footprint& second, const Vec2& offset) {
  const double apart =
      (offset + second.center - first.center).norm() - first.radius - second.radius;
  if (apart >= kMinClearance) return apart;
  double least = std::numeric_limits<double>::max();
  for (const FootprintPart& a : first.parts) {
    for (const FootprintPart& b : second.parts) {
      least = std::min(least, part_clearance(a, b, offset));
    }
  }
  return least;
}

}  // namespace engram::tasks
