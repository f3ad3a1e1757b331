#include "mjcf/mesh_geom.h"

#include <cstddef>

namespace engram::mjcf {
namespace {

ConvexHull hull_of_points(std::span<const Vec3> points) {
  std::vector<engram::Vec3> converted;
  for (const Vec3& point : points) converted.emplace_back(point[0], point[1], point[2]);
  return convex_hull(converted);
}

}  // namespace

Geom mesh_geom(std::span<const Vec3> points) {
  Geom geom;
  geom.type = GeomType::kMesh;
  for (const engram::Vec3& corner : hull_of_points(points).corners) {
    geom.corners.push_back({corner[0], corner[1], corner[2]});
  }
  return geom;
}

ConvexHull hull_of(const Geom& mesh) { return hull_of_points(mesh.corners); }

std::vector<int> triangles_of(const ConvexHull& hull) {
  std::vector<int> triangles;
  for (const ConvexHull::Face& face : hull.faces) {
    const auto loop = hull.loop(face);
    for (std::size_t i = 2; i < loop.size(); ++i) {
      triangles.insert(triangles.end(), {loop[0], loop[i - 1], loop[i]});
    }
  }
  return triangles;
}

}  // namespace engram::mjcf
