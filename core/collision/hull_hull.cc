#include "core/collision/hull_hull.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/index.h"
#include "core/collision/contact_polygon.h"

namespace engram {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();
// Another axis is taken only if its gap is larger by this, m: then normals do not flip.
constexpr double kFacePreference = 1e-5;
constexpr double kEdgePreference = 1e-4;
constexpr double kMinSine = 1e-3;  // between edges that cross
// Corners of faces that are clipped: both fit into a ContactPolygon.
constexpr int kMaxLoop = ContactPolygon::kCapacity / 2;

// Corners and face normals of one hull in the frame of the other.
class MovedHull {
 public:
  MovedHull(const HullPose& of, const Frame& to) : hull_(of.hull) {
    const Mat3 axes = to.axes.transpose() * of.frame.axes;
    const Vec3 pos = to.axes.transpose() * (of.frame.pos - to.pos);
    for (std::size_t i = 0; i < hull_.corners.size(); ++i) {
      corners_[i] = pos + axes * hull_.corners[i];
    }
    for (std::size_t i = 0; i < hull_.faces.size(); ++i) {
      normals_[i] = axes * hull_.faces[i].normal;
      offsets_[i] = hull_.faces[i].offset + normals_[i].dot(pos);
    }
  }

  const ConvexHull& hull() const { return hull_; }
  const Vec3& corner(int i) const { return corners_[at(i)]; }
  const Vec3& normal(int face) const { return normals_[at(face)]; }
  double offset(int face) const { return offsets_[at(face)]; }
  int num_faces() const { return static_cast<int>(hull_.faces.size()); }
  // The least of direction . corner.
  double min_along(const Vec3& direction) const {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < hull_.corners.size(); ++i) {
      least = std::min(least, direction.dot(corners_[i]));
    }
    return least;
  }

 private:
  const ConvexHull& hull_;
  std::array<Vec3, ConvexHull::kMaxCorners> corners_;
  std::array<Vec3, ConvexHull::kMaxFaces> normals_;
  std::array<double, ConvexHull::kMaxFaces> offsets_;
};

struct FaceAxis {
  int face = -1;
  double gap = kNone;
};

// The face of `reference` that separates the hulls most.
FaceAxis find_face(const MovedHull& reference, const MovedHull& other) {
  FaceAxis best;
  for (int face = 0; face < reference.num_faces(); ++face) {
    const double gap = other.min_along(reference.normal(face)) - reference.offset(face);
    if (gap > best.gap) best = {face, gap};
  }
  return best;
}

struct EdgeAxis {
  Vec3 normal = Vec3::Zero();  // from A to B
  double gap = kNone;
  Vec3 on_a, along_a;  // both edges
  Vec3 on_b, along_b;
};

// Tests whether the normals of an edge's faces lie on both sides of a plane.
bool straddles(const MovedHull& of, const ConvexHull::Edge& edge, const Vec3& direction) {
  return of.normal(edge.left).dot(direction) * of.normal(edge.right).dot(direction) < 0;
}

Vec3 outwards_of(const MovedHull& of, const ConvexHull::Edge& edge) {
  return of.normal(edge.left) + of.normal(edge.right);
}

// Pairs of edges that make a face of the Minkowski difference: the arcs between their faces'
// normals cross on the Gauss map.
EdgeAxis find_edges(const MovedHull& a, const MovedHull& b) {
  EdgeAxis best;
  for (const ConvexHull::Edge& of_a : a.hull().edges) {
    const Vec3& on_a = a.corner(of_a.from);
    const Vec3 along_a = a.corner(of_a.to) - on_a;
    const Vec3 outwards = outwards_of(a, of_a);
    for (const ConvexHull::Edge& of_b : b.hull().edges) {
      const Vec3& on_b = b.corner(of_b.from);
      const Vec3 along_b = b.corner(of_b.to) - on_b;
      if (!straddles(b, of_b, along_a) || !straddles(a, of_a, along_b)) continue;
      Vec3 normal = along_a.cross(along_b);
      const double sine = normal.norm() / (along_a.norm() * along_b.norm());
      if (sine < kMinSine) continue;
      normal.normalize();
      if (normal.dot(outwards) < 0) normal = -normal;
      if (normal.dot(outwards_of(b, of_b)) >= 0) continue;  // it crosses the opposite arc
      const double gap = normal.dot(on_b - on_a);
      if (gap > best.gap) best = {normal, gap, on_a, along_a, on_b, along_b};
    }
  }
  return best;
}

// Where the second edge is nearest to the first.
Vec3 nearest_on_b(const EdgeAxis& edges) {
  const double aa = edges.along_a.squaredNorm();
  const double ab = edges.along_a.dot(edges.along_b);
  const double bb = edges.along_b.squaredNorm();
  const Vec3 offset = edges.on_b - edges.on_a;
  const double along =
      (ab * offset.dot(edges.along_a) - aa * offset.dot(edges.along_b)) / (aa * bb - ab * ab);
  return edges.on_b + std::clamp(along, 0.0, 1.0) * edges.along_b;
}

// Corners of a face, at most kMaxLoop of them.
template <class Visit>
void for_each_corner(const MovedHull& of, int face, const Visit& visit) {
  const auto loop = of.hull().loop(of.hull().faces[at(face)]);
  const int count = std::min(static_cast<int>(loop.size()), kMaxLoop);
  for (int i = 0; i < count; ++i) {
    visit(of.corner(loop[at(i) * loop.size() / at(count)]));
  }
}

int opposing_face(const MovedHull& of, const Vec3& normal) {
  int best = 0;
  for (int face = 1; face < of.num_faces(); ++face) {
    if (of.normal(face).dot(normal) < of.normal(best).dot(normal)) best = face;
  }
  return best;
}

// The reference face's plane, in the frame of which the incident face is clipped.
class ReferencePlane {
 public:
  ReferencePlane(const MovedHull& of, int face)
      : normal_(of.normal(face)),
        offset_(of.offset(face)),
        x_(normal_.unitOrthogonal()),
        y_(normal_.cross(x_)) {}

  Vec3 to_local(const Vec3& p) const { return {p.dot(x_), p.dot(y_), p.dot(normal_) - offset_}; }
  // With this height over the plane.
  Vec3 from_local(const Vec3& p, double height) const {
    return p.x() * x_ + p.y() * y_ + (offset_ + height) * normal_;
  }

 private:
  Vec3 normal_;
  double offset_;
  Vec3 x_, y_;
};

// The part of the incident face over the reference face that is within reach: up to four points.
ContactPolygon clip_faces(const MovedHull& reference, int face, const MovedHull& incident,
                          const ReferencePlane& plane, double reach) {
  ContactPolygon clipped;
  for_each_corner(incident, opposing_face(incident, reference.normal(face)),
                  [&](const Vec3& corner) { clipped.push(plane.to_local(corner)); });
  ContactPolygon sides;
  for_each_corner(reference, face, [&](const Vec3& corner) { sides.push(plane.to_local(corner)); });
  for (int i = 0; i < sides.size(); ++i) {
    const Vec3& from = sides[i];
    const Vec3 along = (sides[(i + 1) % sides.size()] - from).normalized();
    // Loops run counter-clockwise: outwards is to the right.
    clipped.clip(along.y(), -along.x(), along.y() * from.x() - along.x() * from.y());
  }
  ContactPolygon near;
  for (int i = 0; i < clipped.size(); ++i) {
    if (clipped[i].z() < reach) near.push(clipped[i]);
  }
  near.reduce_to_four();
  return near;
}

// Points in A's frame.
ContactPoints face_points(const MovedHull& a, const MovedHull& b, int face, bool of_a,
                          double reach) {
  const MovedHull& reference = of_a ? a : b;
  const ReferencePlane plane(reference, face);
  const ContactPolygon near = clip_faces(reference, face, of_a ? b : a, plane, reach);
  const Vec3 normal = of_a ? Vec3(-a.normal(face)) : b.normal(face);
  ContactPoints points;
  for (int i = 0; i < near.size(); ++i) {
    const double gap = near[i].z();
    points.push({plane.from_local(near[i], of_a ? gap : 0), normal, gap});
  }
  return points;
}

}  // namespace

ContactPoints hull_hull(const HullPose& a, const HullPose& b, double reach) {
  const MovedHull hull_a(a, a.frame);
  const MovedHull hull_b(b, a.frame);
  const FaceAxis face_a = find_face(hull_a, hull_b);
  if (face_a.gap >= reach) return {};
  const FaceAxis face_b = find_face(hull_b, hull_a);
  if (face_b.gap >= reach) return {};
  const EdgeAxis edges = find_edges(hull_a, hull_b);
  if (edges.gap >= reach) return {};

  ContactPoints points;
  const bool of_a = face_b.gap <= face_a.gap + kFacePreference;
  if (edges.gap <= std::max(face_a.gap, face_b.gap) + kEdgePreference) {
    points = face_points(hull_a, hull_b, of_a ? face_a.face : face_b.face, of_a, reach);
  }
  if (points.empty() && edges.gap > kNone) {
    points.push({nearest_on_b(edges), -edges.normal, edges.gap});
  }
  for (int i = 0; i < points.size(); ++i) {
    points[i].pos = a.frame.pos + a.frame.axes * points[i].pos;
    points[i].normal = a.frame.axes * points[i].normal;
  }
  return points;
}

double hull_separation(const HullPose& a, const HullPose& b) {
  const MovedHull hull_a(a, a.frame);
  const MovedHull hull_b(b, a.frame);
  return std::max(find_face(hull_a, hull_b).gap, find_face(hull_b, hull_a).gap);
}

}  // namespace engram
