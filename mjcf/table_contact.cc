#include "mjcf/table_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"

namespace engram::mjcf {
namespace {

constexpr double kTolerance = 1e-9;  // m

// The vertical, in the geom's frame.
Vec3 vertical(const Quat& q) {
  const auto [w, x, y, z] = q;
  return {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
}

// Half the height of a geom.
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
  }
  return 0;
}

// Contacts of a geom with a plane: a flat axis of a box doubles them; a capsule and a cylinder have
// two on a flat axis, a standing cylinder three.
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
