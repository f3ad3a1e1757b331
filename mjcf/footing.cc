#include "mjcf/footing.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"

namespace engram::mjcf {
namespace {

constexpr double kTolerance = 1e-9;  // m

// The vertical, in the primitive's frame.
Vec3 vertical(const Quat& q) {
  const auto [w, x, y, z] = q;
  return {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)};
}

// Half the height of a primitive.
double half_height(const Primitive& primitive) {
  const auto [a, b, c] = primitive.size;
  const Vec3 up = vertical(primitive.quat);
  switch (primitive.shape) {
    case Shape::kBox:
      return a * std::abs(up[0]) + b * std::abs(up[1]) + c * std::abs(up[2]);
    case Shape::kSphere:
      return a;
    case Shape::kCapsule:
      return a + b * std::abs(up[2]);
    case Shape::kCylinder:
      return a * real::hypot(up[0], up[1]) + b * std::abs(up[2]);
    case Shape::kEllipsoid:
      return real::hypot(a * up[0], b * up[1], c * up[2]);
  }
  return 0;
}

// How many of a box's axes lie flat, and of a capsule's or a cylinder's own one.
int contacts_on_plane(const Primitive& primitive) {
  const auto [a, b, c] = primitive.size;
  const Vec3 up = vertical(primitive.quat);
  const auto flat = [](double length) { return std::abs(length) < kTolerance; };
  switch (primitive.shape) {
    case Shape::kBox:
      return (flat(a * up[0]) ? 2 : 1) * (flat(b * up[1]) ? 2 : 1) * (flat(c * up[2]) ? 2 : 1);
    case Shape::kCapsule:
      return flat(b * up[2]) ? 2 : 1;
    case Shape::kCylinder:
      if (flat(b * up[2])) return 2;
      return flat(a * real::hypot(up[0], up[1])) ? 3 : 1;
    case Shape::kSphere:
    case Shape::kEllipsoid:
      break;
  }
  return 1;
}

}  // namespace

double lowest_point(const Primitive& primitive) {
  return primitive.pos[2] - half_height(primitive);
}

double standing_height(const Prop& prop) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const Primitive& primitive : prop.primitives) {
    if (primitive.collides) lowest = std::min(lowest, lowest_point(primitive));
  }
  return -lowest;
}

int standing_contacts(const Prop& prop) {
  const double ground = -standing_height(prop) + kTolerance;
  int count = 0;
  for (const Primitive& primitive : prop.primitives) {
    if (primitive.collides && lowest_point(primitive) <= ground) {
      count += contacts_on_plane(primitive);
    }
  }
  return count;
}

}  // namespace engram::mjcf
