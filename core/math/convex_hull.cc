#include "core/math/convex_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram {
namespace {

// Shares of the size.
constexpr double kCoplanar = 1e-6;  // points no farther from a plane lie on it
constexpr double kMinCorner = 1e-4;
constexpr double kMinThickness = 1e-3;
constexpr double kMinTriangle = 1e-5;  // height of triangles that define planes

using Corners = std::vector<Vec3>;
using Mask = std::uint64_t;  // a bit for each corner

[[noreturn]] void refuse(const std::string& why) { throw Error(Error::kInvalidArgument, why); }

// Half the diagonal of the bounding box.
double size_of(std::span<const Vec3> points) {
  Vec3 low = points[0];
  Vec3 high = low;
  for (const Vec3& point : points) {
    low = low.cwiseMin(point);
    high = high.cwiseMax(point);
  }
  return 0.5 * (high - low).norm();
}

// The first of the points at which `measure` is greatest.
template <class Measure>
std::size_t farthest(std::span<const Vec3> points, const Measure& measure) {
  std::size_t best = 0;
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (measure(points[i]) > measure(points[best])) best = i;
  }
  return best;
}

// A tetrahedron of points that are far from one another.
Corners first_corners(std::span<const Vec3> points, double size) {
  const Vec3 origin = points[farthest(points, [&](const Vec3& p) { return p.x(); })];
  const Vec3 along =
      points[farthest(points, [&](const Vec3& p) { return (p - origin).squaredNorm(); })];
  const Vec3 line = (along - origin).normalized();
  const auto from_line = [&](const Vec3& p) { return (p - origin).cross(line).norm(); };
  const Vec3 aside = points[farthest(points, from_line)];
  const Vec3 normal = line.cross(aside - origin).normalized();
  const auto from_plane = [&](const Vec3& p) { return std::abs((p - origin).dot(normal)); };
  const Vec3 above = points[farthest(points, from_plane)];
  const double least = kMinThickness * size;
  if (from_line(aside) <= least || from_plane(above) <= least) {
    refuse("its points are flat, or nearly so; a solid needed");
  }
  return {origin, along, aside, above};
}

// --- faces of corners ---

struct Plane {
  Vec3 normal;
  double offset = 0;
  double area = 0;
  Mask triangle = 0;
  Mask corners = 0;  // those that lie on it
};

// The plane of three corners if all others lie on one side of it.
std::optional<Plane> supporting_plane(const Corners& corners, const std::array<std::size_t, 3>& of,
                                      double size) {
  const Vec3& a = corners[of[0]];
  const Vec3& b = corners[of[1]];
  const Vec3& c = corners[of[2]];
  const Vec3 cross = (b - a).cross(c - a);
  const double area = cross.norm();
  const double longest = std::max({(b - a).norm(), (c - a).norm(), (c - b).norm()});
  if (area < kMinTriangle * size * longest) return {};
  Plane plane{cross / area, 0, area, 0, 0};
  bool above = false;
  bool below = false;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const double height = plane.normal.dot(corners[i] - a);
    above = above || height > kCoplanar * size;
    below = below || height < -kCoplanar * size;
    if (above && below) return {};
    if (std::abs(height) <= kCoplanar * size) plane.corners |= Mask{1} << i;
  }
  if (above) plane.normal = -plane.normal;
  plane.offset = plane.normal.dot(a);
  for (const std::size_t i : of) plane.triangle |= Mask{1} << i;
  return plane;
}

// The planes of all faces; large triangles first, whose planes are the most exact.
std::vector<Plane> face_planes(const Corners& corners, double size) {
  std::vector<Plane> found;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = i + 1; j < corners.size(); ++j) {
      for (std::size_t k = j + 1; k < corners.size(); ++k) {
        const auto plane = supporting_plane(corners, {i, j, k}, size);
        if (plane) found.push_back(*plane);
      }
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Plane& a, const Plane& b) { return a.area > b.area; });
  std::vector<Plane> faces;
  for (const Plane& plane : found) {
    const bool known = std::ranges::any_of(
        faces, [&](const Plane& face) { return (plane.triangle & ~face.corners) == 0; });
    if (!known) faces.push_back(plane);
  }
  return faces;
}

// Corners of a face, counter-clockwise seen from outside: a monotone chain, without those that lie
// on the line between their neighbours.
std::vector<int> loop_of(const Corners& corners, const Plane& plane, double size) {
  const Vec3 x = plane.normal.unitOrthogonal();
  const Vec3 y = plane.normal.cross(x);
  struct Point {
    double x, y;
    int corner;
  };
  std::vector<Point> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if ((plane.corners >> i & 1U) == 0) continue;
    points.push_back({corners[i].dot(x), corners[i].dot(y), static_cast<int>(i)});
  }
  std::ranges::sort(points, {}, [](const Point& p) { return std::pair(p.x, p.y); });
  std::vector<Point> chain;
  const auto is_corner = [&](const Point& a, const Point& b, const Point& c) {
    const double turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    return turn > kMinCorner * size * real::hypot(c.x - a.x, c.y - a.y);
  };
  const auto extend = [&](const Point& point, std::size_t least) {
    while (chain.size() > least && !is_corner(chain[chain.size() - 2], chain.back(), point)) {
      chain.pop_back();
    }
    chain.push_back(point);
  };
  for (const Point& point : points) extend(point, 1);
  const std::size_t lower = chain.size();
  for (std::size_t i = points.size() - 1; i-- > 0;) extend(points[i], lower);
  chain.pop_back();
  std::vector<int> loop;
  for (const Point& point : chain) loop.push_back(point.corner);
  return loop;
}

// Joins the loops' sides; false if they do not close the surface.
bool add_edges(ConvexHull& hull) {
  std::map<std::pair<int, int>, int> sides;
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const auto loop = hull.loop(hull.faces[f]);
    for (std::size_t i = 0; i < loop.size(); ++i) {
      sides[{loop[i], loop[(i + 1) % loop.size()]}] = static_cast<int>(f);
    }
  }
  if (sides.size() != hull.loops.size()) return false;
  for (const auto& [side, left] : sides) {
    const auto other = sides.find({side.second, side.first});
    if (other == sides.end()) return false;
    if (side.first < side.second) {
      hull.edges.push_back({side.first, side.second, left, other->second});
    }
  }
  return true;
}

// The hull of corners, all of which count.
ConvexHull hull_of(Corners corners, double size) {
  ConvexHull hull;
  while (true) {
    hull = {};
    std::vector<Mask> used;
    Mask left_out = 0;
    Mask on_faces = 0;
    for (const Plane& plane : face_planes(corners, size)) {
      const std::vector<int> loop = loop_of(corners, plane, size);
      Mask in_loop = 0;
      for (const int corner : loop) in_loop |= Mask{1} << corner;
      left_out |= plane.corners & ~in_loop;
      on_faces |= in_loop;
      hull.faces.push_back({plane.normal, plane.offset, static_cast<int>(hull.loops.size()),
                            static_cast<int>(loop.size())});
      hull.loops.insert(hull.loops.end(), loop.begin(), loop.end());
    }
    Corners kept;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (((on_faces & ~left_out) >> i & 1U) != 0) kept.push_back(corners[i]);
    }
    if (kept.size() == corners.size()) break;
    if (kept.size() < 4) refuse("no solid is left of its points");
    corners = std::move(kept);
  }
  hull.corners = std::move(corners);
  if (hull.faces.size() < 4 || !add_edges(hull)) {
    refuse("the faces of its hull do not fit together; fewer or rounder points needed");
  }
  return hull;
}

}  // namespace

ConvexHull convex_hull(std::span<const Vec3> points) {
  if (points.size() < 4) refuse(std::to_string(points.size()) + " points given, 4 needed");
  const double size = size_of(points);
  ConvexHull hull = hull_of(first_corners(points, size), size);
  while (true) {
    // The point that is farthest outside of each face.
    std::vector<std::pair<double, std::size_t>> outside;
    for (const ConvexHull::Face& face : hull.faces) {
      const auto height = [&](const Vec3& p) { return face.normal.dot(p) - face.offset; };
      const std::size_t best = farthest(points, height);
      const double above = height(points[best]);
      if (above > kMinCorner * size) outside.emplace_back(-above, best);
    }
    std::ranges::sort(outside);
    Corners corners = hull.corners;
    for (const auto& [above, best] : outside) {
      if (corners.size() == at(ConvexHull::kMaxCorners)) break;
      const Vec3& point = points[best];
      if (std::ranges::find(corners, point) == corners.end()) corners.push_back(point);
    }
    if (corners.size() == hull.corners.size()) return hull;
    ConvexHull larger = hull_of(std::move(corners), size);
    if (larger.corners.size() <= hull.corners.size() &&
        moments_of(larger).volume <= moments_of(hull).volume * (1 + kCoplanar)) {
      return hull;
    }
    hull = std::move(larger);
  }
}

ConvexHull box_hull(const Vec3& half) {
  Corners corners;
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) {
      for (const double z : {-1.0, 1.0}) corners.push_back(half.cwiseProduct(Vec3(x, y, z)));
    }
  }
  ConvexHull hull;
  hull.corners = std::move(corners);
  const auto corner = [](const std::array<bool, 3>& high) {
    return 4 * (high[0] ? 1 : 0) + 2 * (high[1] ? 1 : 0) + (high[2] ? 1 : 0);
  };
  for (std::size_t k = 0; k < 3; ++k) {
    for (const bool high : {false, true}) {
      const double side = high ? 1.0 : -1.0;
      hull.faces.push_back({side * Vec3::Unit(static_cast<Eigen::Index>(k)),
                            half[static_cast<Eigen::Index>(k)], static_cast<int>(hull.loops.size()),
                            4});
      std::array<std::array<bool, 2>, 4> turns = {
          {{false, false}, {true, false}, {true, true}, {false, true}}};
      if (!high) std::ranges::reverse(turns);
      for (const auto& [one, other] : turns) {
        std::array<bool, 3> at_high{};
        at_high[k] = high;
        at_high[(k + 1) % 3] = one;
        at_high[(k + 2) % 3] = other;
        hull.loops.push_back(corner(at_high));
      }
    }
  }
  (void)add_edges(hull);
  return hull;
}

HullMoments moments_of(const ConvexHull& hull) {
  HullMoments sum;
  const Vec3& apex = hull.corners[0];
  for (const ConvexHull::Face& face : hull.faces) {
    const auto loop = hull.loop(face);
    // Tetrahedra over the fan of triangles.
    for (std::size_t i = 2; i < loop.size(); ++i) {
      const Vec3& a = hull.corners[at(loop[0])];
      const Vec3& b = hull.corners[at(loop[i - 1])];
      const Vec3& c = hull.corners[at(loop[i])];
      const double volume = (a - apex).dot((b - apex).cross(c - apex)) / 6;
      const Vec3 total = apex + a + b + c;
      sum.volume += volume;
      sum.first += volume / 4 * total;
      sum.second += volume / 20 *
                    (total * total.transpose() + apex * apex.transpose() + a * a.transpose() +
                     b * b.transpose() + c * c.transpose());
    }
  }
  return sum;
}

}  // namespace engram
