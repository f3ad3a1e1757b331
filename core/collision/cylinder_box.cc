#include "core/collision/cylinder_box.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/index.h"
#include "core/collision/contact_polygon.h"

namespace engram {
namespace {

constexpr int kSides = 16;  // of a cap's polygon
// Cosine of the angle between axis and normal from which a cap faces the box.
constexpr double kCapCosine = 0.7071067811865476;
// A round side takes another normal than a box's face only if the overlap is less by this, m.
constexpr double kBoxFacePreference = 1e-5;
// Cosine of the angle between axis and an edge from which the side touches it along a line.
constexpr double kAlongEdge = 0.98;

// cos(2 pi i / kSides)
constexpr std::array<double, kSides> kCosines = {
    1,  0.9238795325112867,  0.7071067811865476,  0.3826834323650898,
    0,  -0.3826834323650898, -0.7071067811865476, -0.9238795325112867,
    -1, -0.9238795325112867, -0.7071067811865476, -0.3826834323650898,
    0,  0.3826834323650898,  0.7071067811865476,  0.9238795325112867};
double cosine_of(int side) { return kCosines[at(side)]; }
double sine_of(int side) { return kCosines[at((side + 3 * kSides / 4) % kSides)]; }

// The cylinder in the box's frame.
class LocalCylinder {
 public:
  LocalCylinder(const CylinderPose& cylinder, const BoxPose& box)
      : radius(cylinder.radius),
        half(cylinder.half_height),
        center(box.frame.axes.transpose() * (cylinder.frame.pos - box.frame.pos)),
        axis(box.frame.axes.transpose() * cylinder.frame.axes.col(2)),
        side(box.frame.axes.transpose() * cylinder.frame.axes.col(0)) {}

  // Extent from the centre along a unit vector.
  double extent(const Vec3& direction) const { return extent_at(direction.dot(axis)); }
  // `along`: cosine of the angle between that vector and the axis.
  double extent_at(double along) const {
    return half * std::abs(along) + radius * std::sqrt(std::max(0.0, 1 - along * along));
  }
  // The unit vector across the axis that is nearest to `direction`; `side` if there is none.
  Vec3 across(const Vec3& direction) const {
    const Vec3 rest = direction - direction.dot(axis) * axis;
    const double length = rest.norm();
    return length > 1e-9 ? Vec3(rest / length) : side;
  }

  double radius;
  double half;
  Vec3 center;
  Vec3 axis;
  Vec3 side;  // a unit vector across the axis
};

double box_extent(const Vec3& half, const Vec3& direction) {
  return half.dot(direction.cwiseAbs());
}

enum class Feature { kBoxFace, kCap, kSide };

struct CylinderAxis {
  Feature feature = Feature::kBoxFace;
  Vec3 normal = Vec3::Zero();  // from the box to the cylinder
  double overlap = std::numeric_limits<double>::infinity();
  Vec3 nearest = Vec3::Zero();  // to the box, on the cylinder's axis; of the side
};

// Overlap along an axis of the box, with which the search for the least begins.
void consider_face(int k, const LocalCylinder& cylinder, const Vec3& half, CylinderAxis& best) {
  const double offset = cylinder.center[k];
  const double overlap = half[k] + cylinder.extent_at(cylinder.axis[k]) - std::abs(offset);
  if (!(overlap < best.overlap)) return;
  const Vec3 direction = Vec3::Unit(k);
  best = {Feature::kBoxFace, offset < 0 ? Vec3(-direction) : direction, overlap};
}

// Overlap along a unit vector, which then points from the box to the cylinder.
void consider(Feature feature, Vec3 direction, const LocalCylinder& cylinder, const Vec3& half,
              CylinderAxis& best) {
  const double offset = cylinder.center.dot(direction);
  if (offset < 0) direction = -direction;
  const double overlap =
      box_extent(half, direction) + cylinder.extent(direction) - std::abs(offset);
  if (overlap < best.overlap - kBoxFacePreference) best = {feature, direction, overlap};
}

CylinderAxis find_face_axis(const LocalCylinder& cylinder, const Vec3& half) {
  CylinderAxis best;
  for (int k = 0; k < 3; ++k) consider_face(k, cylinder, half, best);
  consider(Feature::kCap, cylinder.axis, cylinder, half, best);
  return best;
}

// The point of the axis that is nearest to the box, by alternating projections.
Vec3 nearest_on_axis(const LocalCylinder& cylinder, const Vec3& half) {
  constexpr int kRounds = 8;
  Vec3 point = cylinder.center;
  for (int i = 0; i < kRounds; ++i) {
    const Vec3 in_box = point.cwiseMin(half).cwiseMax(-half);
    const double along = (in_box - cylinder.center).dot(cylinder.axis);
    const Vec3 before = point;
    point = cylinder.center + std::clamp(along, -cylinder.half, cylinder.half) * cylinder.axis;
    if (point == before) break;  // as in all rounds from here
  }
  return point;
}

CylinderAxis find_cylinder_axis(const LocalCylinder& cylinder, const Vec3& half) {
  CylinderAxis best = find_face_axis(cylinder, half);
  const Vec3 point = nearest_on_axis(cylinder, half);
  const Vec3 offset = point - point.cwiseMin(half).cwiseMax(-half);
  const Vec3 radial = offset - offset.dot(cylinder.axis) * cylinder.axis;
  const double length = radial.norm();
  if (length > 1e-9) {
    consider(Feature::kSide, radial / length, cylinder, half, best);
    best.nearest = point;
  }
  return best;
}

// Contacts in the box's frame: points on the box and their gaps.
class Collector {
 public:
  Collector(const BoxPose& box, const Vec3& normal, double reach)
      : box_(box), normal_(box.frame.axes * normal), reach_(reach) {}
  void add(const Vec3& on_box, double gap) { add_along(normal_, on_box, gap); }
  void add_along(const Vec3& normal, const Vec3& on_box, double gap) {
    if (gap < reach_) points_.push({box_.frame.pos + box_.frame.axes * on_box, normal, gap});
  }
  const ContactPoints& points() const { return points_; }

 private:
  const BoxPose& box_;
  Vec3 normal_;
  double reach_;
  ContactPoints points_;
};

// Clips a segment to -half <= x_k <= half for all k but `normal_axis`; false if nothing is left.
bool clip_segment(const Vec3& half, int normal_axis, Vec3& from, Vec3& to) {
  double begin = 0;
  double end = 1;
  const Vec3 along = to - from;
  for (int k = 0; k < 3; ++k) {
    if (k == normal_axis) continue;
    if (std::abs(along[k]) < 1e-9) {
      if (std::abs(from[k]) > half[k]) return false;
      continue;
    }
    const double one = (-half[k] - from[k]) / along[k];
    const double other = (half[k] - from[k]) / along[k];
    begin = std::max(begin, std::min(one, other));
    end = std::min(end, std::max(one, other));
  }
  if (begin > end) return false;
  const Vec3 start = from;
  from = start + along * begin;
  to = start + along * end;
  return true;
}

// The cylinder's cap or side against a face of the box.
void add_on_box_face(const LocalCylinder& cylinder, const Vec3& half, const Vec3& normal,
                     Collector& contacts) {
  int k = 0;
  for (int i = 1; i < 3; ++i) k = std::abs(normal[i]) > std::abs(normal[k]) ? i : k;
  const double along = normal.dot(cylinder.axis);
  const Vec3 down = cylinder.across(-normal);
  const auto add = [&](const Vec3& on_cylinder) {
    const double gap = on_cylinder.dot(normal) - half[k];
    contacts.add(on_cylinder - normal * gap, gap);
  };
  if (std::abs(along) < kCapCosine) {
    Vec3 from = cylinder.center + cylinder.radius * down - cylinder.half * cylinder.axis;
    Vec3 to = from + 2 * cylinder.half * cylinder.axis;
    if (!clip_segment(half, k, from, to)) return;
    add(from);
    add(to);
    return;
  }
  const Vec3 cap = cylinder.center - (along > 0 ? 1.0 : -1.0) * cylinder.half * cylinder.axis;
  const Vec3 aside = cylinder.axis.cross(down);
  const int i = (k + 1) % 3;
  const int j = (k + 2) % 3;
  // Points of the quarters are enough where the whole cap surely is over the face.
  constexpr double kRounding = 1e-9;  // m, more than that of a point
  const double around = cylinder.radius + kRounding;
  bool inside = std::abs(cap[i]) + around <= half[i] && std::abs(cap[j]) + around <= half[j];
  const int step = inside ? kSides / 4 : 1;
  inside = true;
  ContactPolygon rim;
  for (int side = 0; side < kSides; side += step) {
    const Vec3 point = cap + cylinder.radius * (cosine_of(side) * down + sine_of(side) * aside);
    rim.push({point[i], point[j], point.dot(normal) - half[k]});
    inside = inside && std::abs(point[i]) <= half[i] && std::abs(point[j]) <= half[j];
  }
  const auto put = [&](const Vec3& local) {
    Vec3 on_box;
    on_box[i] = local.x();
    on_box[j] = local.y();
    on_box[k] = normal[k] > 0 ? half[k] : -half[k];
    contacts.add(on_box, local.z());
  };
  if (inside) {
    for (int n = 0; n < rim.size(); n += rim.size() / 4) put(rim[n]);
    return;
  }
  for (const double sign : {1.0, -1.0}) {
    rim.clip(sign, 0, half[i]);
    rim.clip(0, sign, half[j]);
  }
  rim.reduce_to_four();
  for (int n = 0; n < rim.size(); ++n) put(rim[n]);
}

// A face of the box against a cap.
void add_on_cap(const LocalCylinder& cylinder, const Vec3& half, const Vec3& normal,
                Collector& contacts) {
  int k = 0;  // the box's face that opposes the cap
  for (int i = 1; i < 3; ++i) k = std::abs(normal[i]) > std::abs(normal[k]) ? i : k;
  const int i = (k + 1) % 3;
  const int j = (k + 2) % 3;
  const Vec3 cap = cylinder.center - cylinder.half * normal;
  const Vec3 x = cylinder.side;
  const Vec3 y = normal.cross(x);
  ContactPolygon face;
  for (const auto& [sign_i, sign_j] : {std::array{1, 1}, {1, -1}, {-1, -1}, {-1, 1}}) {
    Vec3 corner;
    corner[i] = sign_i * half[i];
    corner[j] = sign_j * half[j];
    corner[k] = normal[k] > 0 ? half[k] : -half[k];
    const Vec3 offset = corner - cap;
    face.push({offset.dot(x), offset.dot(y), -offset.dot(normal)});
  }
  for (int side = 0; side < kSides; ++side) {
    face.clip(cosine_of(side), sine_of(side), cylinder.radius);
  }
  face.reduce_to_four();
  for (int n = 0; n < face.size(); ++n) {
    const Vec3& local = face[n];
    contacts.add(cap + local.x() * x + local.y() * y - local.z() * normal, local.z());
  }
}

// The round side against an edge or a corner.
void add_on_side(const LocalCylinder& cylinder, const Vec3& half, const CylinderAxis& axis,
                 Collector& contacts) {
  const auto add = [&](const Vec3& on_axis) {
    const Vec3 on_box = on_axis.cwiseMin(half).cwiseMax(-half);
    contacts.add(on_box, (on_axis - on_box).dot(axis.normal) - cylinder.radius);
  };
  int k = 0;
  for (int i = 1; i < 3; ++i) {
    k = std::abs(cylinder.axis[i]) > std::abs(cylinder.axis[k]) ? i : k;
  }
  if (std::abs(cylinder.axis[k]) < kAlongEdge) return add(axis.nearest);
  const double one = (-half[k] - cylinder.center[k]) / cylinder.axis[k];
  const double other = (half[k] - cylinder.center[k]) / cylinder.axis[k];
  const double begin = std::max(-cylinder.half, std::min(one, other));
  const double end = std::min(cylinder.half, std::max(one, other));
  if (begin > end) return;
  add(cylinder.center + begin * cylinder.axis);
  add(cylinder.center + end * cylinder.axis);
}

// A rim against an edge or a corner, which no axis above describes: the nearest points of the box
// and of the cylinder with rounded rims. `axis` serves where even that overlaps.
void add_on_rim(const LocalCylinder& cylinder, const Vec3& half, const CylinderAxis& axis,
                const Mat3& axes, Collector& contacts) {
  constexpr double kRounding = 0.002;  // m
  constexpr int kRounds = 24;          // of alternating projections
  const double radius = cylinder.radius - kRounding;
  const double half_height = cylinder.half - kRounding;
  Vec3 inner = cylinder.center;
  Vec3 on_box = inner;
  for (int i = 0; i < kRounds; ++i) {
    on_box = inner.cwiseMin(half).cwiseMax(-half);
    const Vec3 offset = on_box - cylinder.center;
    const double along = offset.dot(cylinder.axis);
    const Vec3 radial = offset - along * cylinder.axis;
    const Vec3 before = inner;
    inner = cylinder.center + std::clamp(along, -half_height, half_height) * cylinder.axis +
            radial * std::min(1.0, radius / std::max(radial.norm(), 1e-9));
    if (inner == before) break;  // as in all rounds from here
  }
  const Vec3 offset = inner - on_box;
  const double distance = offset.norm();
  if (distance > 1e-6) {
    contacts.add_along(axes * (offset / distance), on_box, distance - kRounding);
  } else {
    contacts.add(on_box, -axis.overlap);
  }
}

}  // namespace

ContactPoints cylinder_box(const CylinderPose& cylinder, const BoxPose& box, double reach) {
  const LocalCylinder local(cylinder, box);
  const CylinderAxis axis = find_cylinder_axis(local, box.half);
  if (-axis.overlap >= reach) return {};
  Collector contacts(box, axis.normal, reach);
  switch (axis.feature) {
    case Feature::kBoxFace:
      add_on_box_face(local, box.half, axis.normal, contacts);
      break;
    case Feature::kCap:
      add_on_cap(local, box.half, axis.normal, contacts);
      break;
    case Feature::kSide:
      add_on_side(local, box.half, axis, contacts);
      break;
  }
  if (contacts.points().empty()) add_on_rim(local, box.half, axis, box.frame.axes, contacts);
  return contacts.points();
}

double cylinder_box_separation(const CylinderPose& cylinder, const BoxPose& box) {
  return -find_face_axis(LocalCylinder(cylinder, box), box.half).overlap;
}

}  // namespace engram
