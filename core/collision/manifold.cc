#include "core/collision/manifold.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram {
namespace {

constexpr double kMarginShare = 0.15;  // of the smallest half extent
constexpr double kMaxMargin = 0.015;   // m
constexpr double kSlideShare = 0.8;    // of the margin: a point that has slid farther is dropped
// By number of points: relative motion that is too much, as a share of the margin.
constexpr std::array<double, 5> kMotionShare = {0.5, 0.125, 0.25, 0.375, 0.375};
constexpr double kMinCosine = 0.9999;  // between quaternions
constexpr double kMinCosineNoPoints = 0.9998;

std::array<double, 5> min_cosines(const Vec3& half, double margin) {
  std::array<double, 5> cosines;
  for (std::size_t count = 0; count < cosines.size(); ++count) {
    const double angle = kMotionShare[count] * margin / half.norm();
    cosines[count] = std::max(real::cos(angle), count == 0 ? kMinCosineNoPoints : kMinCosine);
  }
  return cosines;
}

Vec3 to_local(const Frame& frame, const Vec3& point) {
  return frame.axes.transpose() * (point - frame.pos);
}

ManifoldPoint localize(const BoxPose& a, const BoxPose& b, const ContactPoint& point) {
  return {to_local(a.frame, point.pos + point.normal * point.gap), to_local(b.frame, point.pos)};
}

void set_reference(Manifold& manifold, const ManifoldBox& a, const ManifoldBox& b) {
  manifold.known = true;
  manifold.position = to_local(b.pose.frame, a.pose.frame.pos);
  manifold.quat_a = a.quat;
  manifold.quat_b = b.quat;
}

}  // namespace

ManifoldLimits manifold_limits(const Vec3& half_a, const Vec3& half_b) {
  ManifoldLimits limits;
  limits.margin =
      std::min(kMarginShare * std::min(half_a.minCoeff(), half_b.minCoeff()), kMaxMargin);
  limits.cosine_a = min_cosines(half_a, limits.margin);
  limits.cosine_b = min_cosines(half_b, limits.margin);
  return limits;
}

Eigen::Vector4d manifold_quat(const Mat3& axes) {
  const Quat quat(axes);
  const Eigen::Vector4d values(quat.w(), quat.x(), quat.y(), quat.z());
  return values[0] < 0 ? Eigen::Vector4d(-values) : values;
}

bool refresh_manifold(Manifold& manifold, const ManifoldBox& a, const ManifoldBox& b,
                      const ManifoldLimits& limits) {
  if (!manifold.known && manifold.num_points == 0) return true;
  const Mat3 rotation = b.pose.frame.axes.transpose() * a.pose.frame.axes;
  const Vec3 position = to_local(b.pose.frame, a.pose.frame.pos);
  const int before = manifold.num_points;
  const double slide = kSlideShare * limits.margin;
  for (int i = before - 1; i >= 0; --i) {
    const ManifoldPoint& point = manifold.points[at(i)];
    const Vec3 offset = position + rotation * point.a - point.b;
    const Vec3 aside = offset - manifold.normal * offset.dot(manifold.normal);
    if (aside.squaredNorm() <= slide * slide) continue;
    manifold.points[at(i)] = manifold.points[at(--manifold.num_points)];
  }
  if (!manifold.known || manifold.num_points != before) return true;
  const auto count = at(manifold.num_points);
  if ((position - manifold.position).cwiseAbs().maxCoeff() > kMotionShare[count] * limits.margin) {
    return true;
  }
  return a.quat.dot(manifold.quat_a) < limits.cosine_a[count] ||
         b.quat.dot(manifold.quat_b) < limits.cosine_b[count];
}

void find_manifold(Manifold& manifold, const ManifoldBox& a, const ManifoldBox& b, double reach) {
  const ContactPoints points = box_box(a.pose, b.pose, reach);
  set_reference(manifold, a, b);
  manifold.num_points = std::min(points.size(), Manifold::kMaxPoints);
  for (int i = 0; i < manifold.num_points; ++i) {
    manifold.points[at(i)] = localize(a.pose, b.pose, points[i]);
  }
  if (manifold.num_points > 0) manifold.normal = b.pose.frame.axes.transpose() * points[0].normal;
}

ContactPoints manifold_points(const Manifold& manifold, const BoxPose& a, const BoxPose& b,
                              double reach) {
  ContactPoints points;
  const Vec3 normal = b.frame.axes * manifold.normal;
  for (int i = 0; i < manifold.num_points; ++i) {
    const ManifoldPoint& point = manifold.points[at(i)];
    const Vec3 on_b = b.frame.pos + b.frame.axes * point.b;
    const double gap = (a.frame.pos + a.frame.axes * point.a - on_b).dot(normal);
    if (gap <= reach) points.push({on_b, normal, gap});
  }
  return points;
}

}  // namespace engram
