#include "mjcf/inertia.h"

#include <cstddef>
#include <numbers>

#include "mjcf/mesh_geom.h"

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

double volume(const Geom& geom) {
  constexpr double kPi = std::numbers::pi;
  const auto [a, b, c] = geom.size;
  switch (geom.type) {
    case GeomType::kBox:
      return 8 * a * b * c;
    case GeomType::kSphere:
      return 4.0 / 3.0 * kPi * a * a * a;
    case GeomType::kCylinder:
      return 2 * kPi * a * a * b;
    case GeomType::kMesh:
      return moments_of(hull_of(geom)).volume;
    case GeomType::kCapsule:
    case GeomType::kEllipsoid:
      break;
  }
  return 0;
}

// Mean squares of the coordinates over the geom's volume, in its own frame.
Vec3 mean_squares(const Geom& geom) {
  const auto [a, b, c] = geom.size;
  switch (geom.type) {
    case GeomType::kBox:
      return {a * a / 3, b * b / 3, c * c / 3};
    case GeomType::kSphere:
      return {a * a / 5, a * a / 5, a * a / 5};
    case GeomType::kCylinder:
      return {a * a / 4, a * a / 4, b * b / 3};
    case GeomType::kMesh:  // see add_mesh_moments
    case GeomType::kCapsule:
    case GeomType::kEllipsoid:
      break;
  }
  return {};
}

// Centre of a geom's volume, in the prop's frame.
Vec3 center_of(const Geom& geom) {
  Vec3 center = geom.pos;
  if (geom.type != GeomType::kMesh) return center;
  const HullMoments moments = moments_of(hull_of(geom));
  const Matrix axes = rotation(geom.quat);
  for (std::size_t i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      center[i] += axes[i][static_cast<std::size_t>(k)] * moments.first[k] / moments.volume;
    }
  }
  return center;
}

// Adds the second moments of a mesh about its own centre.
void add_mesh_moments(const Geom& geom, Matrix& sum) {
  const HullMoments moments = moments_of(hull_of(geom));
  const Matrix axes = rotation(geom.quat);
  Mat3 turned;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      turned(i, k) = axes[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
    }
  }
  const Mat3 central = moments.second - moments.first * moments.first.transpose() / moments.volume;
  const Mat3 result = turned * central * turned.transpose();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      sum[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += result(i, j);
    }
  }
}

Vec3 center_of_mass(const Prop& prop, double total_volume) {
  Vec3 center{};
  for (const Geom& geom : prop.geoms) {
    const double share = volume(geom) / total_volume;
    const Vec3 middle = center_of(geom);
    for (std::size_t k = 0; k < 3; ++k) center[k] += share * middle[k];
  }
  return center;
}

// Integral of x_i x_j over the prop's volume, about a point.
Matrix second_moments(const Prop& prop, const Vec3& about) {
  Matrix moments{};
  for (const Geom& geom : prop.geoms) {
    const Matrix axes = rotation(geom.quat);
    const Vec3 squares = mean_squares(geom);
    const double size = volume(geom);
    const Vec3 middle = center_of(geom);
    if (geom.type == GeomType::kMesh) add_mesh_moments(geom, moments);
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        double mean = (middle[i] - about[i]) * (middle[j] - about[j]);
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
  for (const Geom& geom : prop.geoms) total += volume(geom);
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
