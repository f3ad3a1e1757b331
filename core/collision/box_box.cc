#include "core/collision/box_box.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/base/index.h"
#include "core/collision/contact_polygon.h"

namespace engram {
namespace {

constexpr double kAxisSlack = 1e-6;    // on entries of the relative rotation
constexpr double kFaceScale = 1.0001;  // of the reference face

// A contact normal's axis: a face of A (0 to 2) or of B (3 to 5), and the side of it.
struct Axis {
  int index = -1;
  double side = 1;
};

// Overlap of two boxes along the normal of face `index`, and the side on which B is.
class FaceOverlaps {
 public:
  FaceOverlaps(const BoxPose& a, const BoxPose& b)
      : a_(a),
        b_(b),
        between_(b.frame.pos - a.frame.pos),
        spread_(((a.frame.axes.transpose() * b.frame.axes).array().abs() + kAxisSlack).matrix()) {}

  double overlap(int index, double& side) const {
    const int k = index % 3;
    const bool of_a = index < 3;
    const BoxPose& box = of_a ? a_ : b_;
    const double offset = box.frame.axes.col(k).dot(between_);
    const double across =
        of_a ? spread_.row(k).dot(b_.half.transpose()) : spread_.col(k).dot(a_.half);
    side = offset > 0 ? 1.0 : -1.0;
    return box.half[k] + across - std::abs(offset);
  }

 private:
  const BoxPose& a_;
  const BoxPose& b_;
  Vec3 between_;
  Mat3 spread_;
};

// The axis of least penetration, the first of equals; none if the boxes are farther apart than
// `reach`.
Axis find_axis(const BoxPose& a, const BoxPose& b, double reach) {
  const FaceOverlaps overlaps(a, b);
  Axis best;
  double least = std::numeric_limits<double>::infinity();
  for (int index = 0; index < 6; ++index) {
    double side = 1;
    const double overlap = overlaps.overlap(index, side);
    if (overlap + reach < 0) return {};
    if (overlap < least) {
      least = overlap;
      best = {index, side};
    }
  }
  return best;
}

// The reference face in the frame of which the incident face is clipped: x and y in its plane, z
// along its outward normal.
struct ReferenceFace {
  Vec3 center;
  Vec3 x, y, normal;
  double half_x, half_y;

  Vec3 to_local(const Vec3& point) const {
    const Vec3 offset = point - center;
    return {offset.dot(x), offset.dot(y), offset.dot(normal)};
  }
  bool covers(const Vec3& local) const {
    return std::abs(local.x()) <= half_x && std::abs(local.y()) <= half_y;
  }
};

ReferenceFace make_face(const BoxPose& box, int k, double side) {
  constexpr std::array<std::array<int, 2>, 3> kInPlane = {{{2, 1}, {0, 2}, {0, 1}}};
  const auto [i, j] = kInPlane[at(k)];
  const Vec3 normal = side * box.frame.axes.col(k);
  return {box.frame.pos + normal * box.half[k],
          box.frame.axes.col(i),
          box.frame.axes.col(j),
          normal,
          box.half[i] * kFaceScale,
          box.half[j] * kFaceScale};
}

// Corners of the face that opposes a direction most, in the reference face's frame.
struct IncidentFace {
  std::array<Vec3, 4> corners;
  Vec3 normal;
};

IncidentFace make_incident(const BoxPose& box, const ReferenceFace& reference) {
  constexpr std::array<std::array<int, 2>, 3> kInPlane = {{{1, 2}, {0, 2}, {0, 1}}};
  const Vec3 along = box.frame.axes.transpose() * reference.normal;
  int face = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(along[k]) > std::abs(along[face])) face = k;
  }
  const double side = along[face] > 0 ? -1.0 : (along[face] < 0 ? 1.0 : 0.0);
  const auto [i, j] = kInPlane[at(face)];
  const Vec3 center = box.frame.pos + side * box.half[face] * box.frame.axes.col(face);
  const Vec3 s = box.half[i] * box.frame.axes.col(i);
  const Vec3 r = box.half[j] * box.frame.axes.col(j);
  const Vec3 out = side * box.frame.axes.col(face);
  return {{reference.to_local(center + s + r), reference.to_local(center + s - r),
           reference.to_local(center - s - r), reference.to_local(center - s + r)},
          {out.dot(reference.x), out.dot(reference.y), out.dot(reference.normal)}};
}

// Tests for an incident face that lies beyond an edge of the reference face, so that clipping
// leaves nothing of it.
bool lies_aside(const ReferenceFace& reference, const IncidentFace& incident) {
  constexpr double kBeyond = 1e-6;  // m, more than any rounding
  const auto beyond = [&](int k, double half) {
    const auto& c = incident.corners;
    const double low = std::min(std::min(c[0][k], c[1][k]), std::min(c[2][k], c[3][k]));
    const double high = std::max(std::max(c[0][k], c[1][k]), std::max(c[2][k], c[3][k]));
    return low > half + kBeyond || high < -(half + kBeyond);
  };
  return beyond(0, reference.half_x) || beyond(1, reference.half_y);
}

// Clipped points in the reference face's frame; z is the gap.
class ClippedFace {
 public:
  ClippedFace(const ReferenceFace& reference, const IncidentFace& incident, double reach)
      : reference_(reference), incident_(incident), reach_(reach) {
    add_corners();
    if (points_.size() == 4) return;
    add_reference_corners();
    add_edges();
  }

  ContactPolygon& points() { return points_; }

 private:
  void push(const Vec3& point) { points_.push(point); }

  void add_corners() {
    for (int i = 0; i < 4; ++i) {
      const Vec3& corner = incident_.corners[at(i)];
      near_[at(i)] = corner.z() < reach_;
      inside_[at(i)] = near_[at(i)] && reference_.covers(corner);
      if (inside_[at(i)]) push(corner);
    }
  }

  bool contains(double x, double y) const {
    double low = std::numeric_limits<double>::infinity();
    double high = -low;
    for (int i = 0; i < 4; ++i) {
      const Vec3& from = incident_.corners[at(i)];
      const Vec3& to = incident_.corners[at((i + 1) % 4)];
      const double turn =
          (to.x() - from.x()) * (y - from.y()) - (to.y() - from.y()) * (x - from.x());
      low = std::min(low, turn);
      high = std::max(high, turn);
    }
    return low >= 0 || high <= 0;
  }

  // Corners of the reference face that lie inside the incident one, seen along the normal.
  void add_reference_corners() {
    constexpr double kFlat = 1e-9;
    const Vec3& n = incident_.normal;
    const Vec3& first = incident_.corners[0];
    if (std::abs(n.z()) <= kFlat) return;
    for (const auto& [sign_x, sign_y] : {std::array{1, 1}, {1, -1}, {-1, 1}, {-1, -1}}) {
      const double x = sign_x * reference_.half_x;
      const double y = sign_y * reference_.half_y;
      if (!contains(x, y)) continue;
      const double z = first.z() - (n.x() * (x - first.x()) + n.y() * (y - first.y())) / n.z();
      if (z < reach_) push({x, y, z});
    }
  }

  // Ends of the incident face's edges, cut by the reference face and by the reach.
  void add_edges() {
    for (int i = 0; i < 4; ++i) {
      const int j = (i + 3) % 4;
      if (!near_[at(i)] && !near_[at(j)]) continue;
      if (inside_[at(i)] && inside_[at(j)]) continue;
      const Vec3& from = incident_.corners[at(i)];
      const Vec3 along = incident_.corners[at(j)] - from;
      double begin = 0;
      double end = 1;
      if (!cut(from, along, begin, end) || begin > end) continue;
      if (!inside_[at(i)]) push(from + along * begin);
      if (!inside_[at(j)]) push(from + along * end);
    }
  }

  bool cut(const Vec3& from, const Vec3& along, double& begin, double& end) const {
    constexpr double kParallel = 1e-6;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const std::array<double, 3> low = {-reference_.half_x, -reference_.half_y, -kNone};
    const std::array<double, 3> high = {reference_.half_x, reference_.half_y, reach_};
    for (int k = 0; k < 3; ++k) {
      if (std::abs(along[k]) < kParallel) {
        if (!(low[at(k)] <= from[k] && from[k] <= high[at(k)])) return false;
        continue;
      }
      const double one = (low[at(k)] - from[k]) / along[k];
      const double other = (high[at(k)] - from[k]) / along[k];
      begin = std::max(begin, std::min(one, other));
      end = std::min(end, std::max(one, other));
    }
    return true;
  }

  const ReferenceFace& reference_;
  const IncidentFace& incident_;
  double reach_;
  ContactPolygon points_;
  std::array<bool, 4> near_{};
  std::array<bool, 4> inside_{};
};

}  // namespace

ContactPoints box_box(const BoxPose& a, const BoxPose& b, double reach) {
  ContactPoints points;
  const Axis axis = find_axis(a, b, reach);
  if (axis.index < 0) return points;
  const bool of_a = axis.index < 3;
  const ReferenceFace reference =
      make_face(of_a ? a : b, axis.index % 3, of_a ? axis.side : -axis.side);
  const IncidentFace incident = make_incident(of_a ? b : a, reference);
  if (lies_aside(reference, incident)) return points;
  ClippedFace face(reference, incident, reach);
  ContactPolygon& clipped = face.points();
  clipped.reduce_to_four();
  const Vec3 normal = of_a ? Vec3(-reference.normal) : reference.normal;
  for (int i = 0; i < clipped.size(); ++i) {
    const Vec3& local = clipped[i];
    const Vec3 foot = reference.center + reference.x * local.x() + reference.y * local.y();
    points.push({of_a ? Vec3(foot + reference.normal * local.z()) : foot, normal, local.z()});
  }
  return points;
}

double box_separation(const BoxPose& a, const BoxPose& b) {
  const FaceOverlaps overlaps(a, b);
  double side = 1;
  double least = std::numeric_limits<double>::infinity();
  for (int index = 0; index < 6; ++index) least = std::min(least, overlaps.overlap(index, side));
  return -least;
}

}  // namespace engram
