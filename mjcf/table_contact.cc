#include "mjcf/table_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"

namespace engram::mjcf {
namespace {

constexpr double kTolerance = 1e-9;      // m
constexpr double kMeshTolerance = 1e-6;  // m: files have numbers of single precision

// The vertical, in the geom's frame.
Vec3 vertical(const Quat& q) {
  const auto [w, x, y, z] = q;
  return {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
}

// Height of a corner of a mesh over its origin.
double height_of(const Vec3& corner, const Vec3& up) {
  return corner[0] * up[0] + corner[1] * up[1] + corner[2] * up[2];
}

double lowest_corner(const Geom& mesh) {
  const Vec3 up = vertical(mesh.quat);
  double lowest = std::numeric_limits<double>::infinity();
  for (const Vec3& corner : mesh.corners) lowest = std::min(lowest, height_of(corner, up));
  return lowest;
}

// Half the height of a geom; of a mesh, how far it reaches below its origin.
double half_height(const Geom& geom) {
  const auto [a, b, c] = geom.size;
  const Vec3 up = vertical(geom.quat);
  switch (geom.type) {
    case GeomType::kBox:
      return a * std::abs(up[0]) + b * std::abs(up[1]) + c * std::abs(up[2]);
    case GeomType::kSphere:
      return a;
    case GeomType::kCapsule:
      return a + b * std::abs(up[2]);
    case GeomType::kCylinder:
      return a * real::hypot(up[0], up[1]) + b * std::abs(up[2]);
    case GeomType::kEllipsoid:
      return real::hypot(a * up[0], b * up[1], c * up[2]);
    case GeomType::kMesh:
      return -lowest_corner(geom);
  }
  return 0;
}

// Contacts of a geom with a plane: a flat axis of a box doubles them; a capsule and a cylinder have
// two on a flat axis, a standing cylinder three, a mesh up to four.
int contacts_on_plane(const Geom& geom) {
  const auto [a, b, c] = geom.size;
  const Vec3 up = vertical(geom.quat);
  const auto flat = [](double length) { return std::abs(length) < kTolerance; };
  switch (geom.type) {
    case GeomType::kBox:
      return (flat(a * up[0]) ? 2 : 1) * (flat(b * up[1]) ? 2 : 1) * (flat(c * up[2]) ? 2 : 1);
    case GeomType::kCapsule:
      return flat(b * up[2]) ? 2 : 1;
    case GeomType::kCylinder:
      if (flat(b * up[2])) return 2;
      return flat(a * real::hypot(up[0], up[1])) ? 3 : 1;
    case GeomType::kMesh: {
      const double ground = lowest_corner(geom) + kMeshTolerance;
      const auto low = std::ranges::count_if(
          geom.corners, [&](const Vec3& corner) { return height_of(corner, up) < ground; });
      return std::min(static_cast<int>(low), 4);
    }
    case GeomType::kSphere:
    case GeomType::kEllipsoid:
      break;
  }
  return 1;
}

}  // namespace

double lowest_point(const Geom& geom) { return geom.pos[2] - half_height(geom); }

double height_on_table(const Prop& prop) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Geom& geom : prop.geoms) {
    if (geom.collides) lowest = std::min(lowest, lowest_point(geom));
  }
  return -lowest;
}

int table_contact_count(const Prop& prop) {
  const double ground = -height_on_table(prop) + kTolerance;
  int count = 0;
  for (const Geom& geom : prop.geoms) {
    if (geom.collides && lowest_point(geom) <= ground) {
      count += contacts_on_plane(geom);
    }
  }
  return count;
}

}  // namespace engram::mjcf
