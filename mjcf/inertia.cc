#include "mjcf/inertia.h"

#include <cstddef>
#include <numbers>

namespace engram::mjcf {
namespace {

using Matrix = std::array<Vec3, 3>;

// Columns are the axes of the rotated frame.
Matrix rotation(const Quat& q) {
  const auto [w, x, y, z] = q;
  return {{{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
           {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
           {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}}};
}

double volume(const Primitive& primitive) {
  constexpr double kPi = std::numbers::pi;
  const auto [a, b, c] = primitive.size;
  switch (primitive.shape) {
    case Shape::kBox:
      return 8 * a * b * c;
    case Shape::kSphere:
      return 4.0 / 3.0 * kPi * a * a * a;
    case Shape::kCylinder:
      return 2 * kPi * a * a * b;
    case Shape::kCapsule:
    case Shape::kEllipsoid:
      break;
  }
  return 0;
}

// Mean squares of the coordinates over the primitive's volume, in its own frame.
Vec3 mean_squares(const Primitive& primitive) {
  const auto [a, b, c] = primitive.size;
  switch (primitive.shape) {
    case Shape::kBox:
      return {a * a / 3, b * b / 3, c * c / 3};
    case Shape::kSphere:
      return {a * a / 5, a * a / 5, a * a / 5};
    case Shape::kCylinder:
      return {a * a / 4, a * a / 4, b * b / 3};
    case Shape::kCapsule:
    case Shape::kEllipsoid:
      break;
  }
  return {};
}

Vec3 center_of_mass(const Prop& prop, double total_volume) {
  Vec3 center{};
  for (const Primitive& primitive : prop.primitives) {
    const double share = volume(primitive) / total_volume;
    for (std::size_t k = 0; k < 3; ++k) center[k] += share * primitive.pos[k];
  }
  return center;
}

// Integral of x_i x_j over the prop's volume, about a point.
Matrix second_moments(const Prop& prop, const Vec3& about) {
  Matrix moments{};
  for (const Primitive& primitive : prop.primitives) {
    const Matrix axes = rotation(primitive.quat);
    const Vec3 squares = mean_squares(primitive);
    const double size = volume(primitive);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        double mean = (primitive.pos[i] - about[i]) * (primitive.pos[j] - about[j]);
        for (std::size_t k = 0; k < 3; ++k) mean += axes[i][k] * squares[k] * axes[j][k];
        moments[i][j] += size * mean;
      }
    }
  }
  return moments;
}

}  // namespace

void set_solid_inertia(Prop& prop, double density) {
  double total = 0;
  for (const Primitive& primitive : prop.primitives) total += volume(primitive);
  prop.mass = density * total;
  prop.center_of_mass = center_of_mass(prop, total);

  const Matrix m = second_moments(prop, prop.center_of_mass);
  prop.inertia = {density * (m[1][1] + m[2][2]),
                  density * (m[0][0] + m[2][2]),
                  density * (m[0][0] + m[1][1]),
                  -density * m[0][1],
                  -density * m[0][2],
                  -density * m[1][2]};
}

}  // namespace engram::mjcf
