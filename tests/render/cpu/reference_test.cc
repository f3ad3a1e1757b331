// Every shape against a plain ray tracer in double precision.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "tests/render/render_fixture.h"

namespace engram::test {
namespace {

using Eigen::Matrix3f, Eigen::Vector3d, Eigen::Vector3f;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Where a line is inside of a convex body.
struct Interval {
  double enter = -kInfinity;
  double leave = kInfinity;
  bool empty() const { return enter > leave; }
  void intersect(const Interval& other) {
    enter = std::max(enter, other.enter);
    leave = std::min(leave, other.leave);
  }
};

Interval slab(double origin, double direction, double half) {
  if (direction == 0) return std::abs(origin) <= half ? Interval{} : Interval{1, -1};
  const double a = (-half - origin) / direction;
  const double b = (half - origin) / direction;
  return {std::min(a, b), std::max(a, b)};
}

// |o + t d| <= 1 in the first `dimensions` coordinates.
Interval ball(const Vector3d& o, const Vector3d& d, int dimensions) {
  const double a = d.head(dimensions).squaredNorm();
  const double b = d.head(dimensions).dot(o.head(dimensions));
  const double c = o.head(dimensions).squaredNorm() - 1;
  const double disc = b * b - a * c;
  if (disc < 0) return {1, -1};
  return {(-b - std::sqrt(disc)) / a, (-b + std::sqrt(disc)) / a};
}

Interval hit(const RenderGeom& geom, const Vector3d& o, const Vector3d& d) {
  const double r = geom.size[0];
  const double h = geom.size[1];
  Interval inside;
  switch (geom.shape) {
    case RenderShape::kSphere:
      return ball(o / r, d / r, 3);
    case RenderShape::kEllipsoid: {
      const Vector3d radii(geom.size[0], geom.size[1], geom.size[2]);
      return ball(o.cwiseQuotient(radii), d.cwiseQuotient(radii), 3);
    }
    case RenderShape::kCylinder:
    case RenderShape::kCapsule: {
      inside = ball(o / r, d / r, 2);
      inside.intersect(slab(o.z(), d.z(), h));
      if (geom.shape == RenderShape::kCylinder) return inside;
      for (const double end : {h, -h}) {
        const Interval cap = ball((o - Vector3d(0, 0, end)) / r, d / r, 3);
        if (cap.empty()) continue;
        if (inside.empty()) {
          inside = cap;
        } else {
          inside = {std::min(inside.enter, cap.enter), std::max(inside.leave, cap.leave)};
        }
      }
      return inside;
    }
    case RenderShape::kPlane: {
      if (o.z() <= 0 || d.z() >= 0) return {1, -1};
      const double t = -o.z() / d.z();
      const Vector3d p = o + t * d;
      for (int k = 0; k < 2; ++k) {
        if (geom.size[k] > 0 && std::abs(p[k]) > static_cast<double>(geom.size[k])) return {1, -1};
      }
      return {t, t};
    }
    default:  // box; meshes here are boxes, too
      for (int k = 0; k < 3; ++k) inside.intersect(slab(o[k], d[k], geom.size[k]));
      return inside;
  }
}

// Compares depth and segmentation; returns the number of pixels that see another geom.
int compare(const RenderRig& rig, const Image& image, double near) {
  using Rows = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;
  const Eigen::Matrix3d camera = Rows(rig.camera_pose.data()).cast<double>();
  const Vector3d eye = Eigen::Map<const Vector3f>(rig.camera_pose.data() + 9).cast<double>();
  const double tangent = std::tan(0.5 * rig.scene.cameras[0].fovy);
  int wrong = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double u = ((x + 0.5) / image.width * 2 - 1) * tangent * image.width / image.height;
      const double v = (1 - (y + 0.5) / image.height * 2) * tangent;
      const Vector3d ray = camera * Vector3d(u, v, -1);
      double depth = 100;
      int segment = 0;
      for (std::size_t g = 0; g < rig.scene.geoms.size(); ++g) {
        const float* pose = &rig.geom_pose[12 * g];
        const Eigen::Matrix3d rotation = Rows(pose).cast<double>();
        const Vector3d position = Eigen::Map<const Vector3f>(pose + 9).cast<double>();
        const Interval inside = hit(rig.scene.geoms[g], rotation.transpose() * (eye - position),
                                    rotation.transpose() * ray);
        if (inside.empty() || inside.enter < near || inside.enter >= depth) continue;
        depth = inside.enter;
        segment = rig.scene.geoms[g].segment;
      }
      const std::size_t at = image.at(x, y);
      if (image.segment[at] != segment) {
        ++wrong;
        continue;
      }
      const auto seen = static_cast<double>(image.depth[at]);
      if (segment == 0) {
        CHECK(seen == 0);
      } else if (std::abs(seen - depth) > 2e-3 * depth) {
        ++wrong;
      }
    }
  }
  return wrong;
}

constexpr RenderShape kShapes[] = {
    RenderShape::kPlane,    RenderShape::kSphere, RenderShape::kCapsule, RenderShape::kEllipsoid,
    RenderShape::kCylinder, RenderShape::kBox,    RenderShape::kMesh};

Matrix3f random_rotation(std::mt19937& random) {
  std::normal_distribution<float> normal;
  return Eigen::Quaternionf(normal(random), normal(random), normal(random), normal(random))
      .normalized()
      .toRotationMatrix();
}

// Geoms all around the camera, `distance` metres away: close ones enclose it or cross its near
// plane.
RenderRig random_rig(RenderShape shape, float distance, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> size(0.05F, 0.4F);
  RenderRig rig;
  rig.scene.cameras[0].near_clip = 0.05F;
  for (int i = 0; i < 6; ++i) {
    const std::array<float, 3> sizes = {size(random), size(random), size(random)};
    const Vector3f position(distance * (1 + 0.4F * normal(random)),
                            0.7F * distance * normal(random), 0.7F * distance * normal(random));
    rig.add(shape, sizes, position, random_rotation(random));
    if (shape == RenderShape::kMesh) {
      rig.scene.geoms.back().mesh = i;
      rig.scene.meshes.push_back(box_mesh(sizes[0], sizes[1], sizes[2]));
    }
  }
  return rig;
}

TEST_CASE("the ray caster sees what a plain ray tracer sees", "[render]") {
  for (const RenderShape shape : kShapes) {
    for (const float distance : {0.05F, 0.25F, 0.8F, 2.5F}) {
      int wrong = 0;
      constexpr int kRounds = 8;
      constexpr int kSize = 61;
      for (unsigned seed = 0; seed < kRounds; ++seed) {
        const RenderRig rig = random_rig(shape, distance, seed);
        wrong += compare(rig, rig.render(kSize, kSize - 10), 0.05);
      }
      INFO("shape " << static_cast<int>(shape) << ", distance " << distance);
      // Silhouettes may differ in the last bit of a coordinate.
      CHECK(wrong <= kRounds * kSize * (kSize - 10) / 5000);
    }
  }
}

// How many pixels have another light than a plain ray tracer finds, of those that face the light.
struct Shadows {
  int pixels = 0;
  int dark = 0;
  int wrong = 0;
};

Shadows compare_shadows(const RenderRig& rig, const Vector3d& to_light, int width, int height) {
  using Rows = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;
  const CpuRendererOptions hard{.shadow_rays = 1};
  RenderRig unlit = rig;
  unlit.scene.lights.clear();
  const Image shadowed = rig.render(width, height, hard);
  const Image plain = rig.render(width, height);
  const Image ambient = unlit.render(width, height);
  const Eigen::Matrix3d camera = Rows(rig.camera_pose.data()).cast<double>();
  const Vector3d eye = Eigen::Map<const Vector3f>(rig.camera_pose.data() + 9).cast<double>();
  const double tangent = std::tan(0.5 * rig.scene.cameras[0].fovy);
  Shadows result;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::size_t at = plain.at(x, y);
      if (plain.color(x, y)[0] - ambient.color(x, y)[0] < 8) continue;
      const double u = ((x + 0.5) / width * 2 - 1) * tangent * width / height;
      const double v = (1 - (y + 0.5) / height * 2) * tangent;
      const Vector3d point =
          eye + camera * Vector3d(u, v, -1) * static_cast<double>(plain.depth[at]);
      bool dark = false;
      for (std::size_t g = 0; g < rig.scene.geoms.size(); ++g) {
        const RenderGeom& geom = rig.scene.geoms[g];
        if (geom.shape == RenderShape::kPlane || geom.segment == plain.segment[at]) continue;
        const float* pose = &rig.geom_pose[12 * g];
        const Eigen::Matrix3d rotation = Rows(pose).cast<double>().transpose();
        const Vector3d position = Eigen::Map<const Vector3f>(pose + 9).cast<double>();
        const Interval inside = hit(geom, rotation * (point - position), rotation * to_light);
        dark = dark || (!inside.empty() && inside.leave > 1e-3);
      }
      ++result.pixels;
      result.dark += dark ? 1 : 0;
      result.wrong += dark != (shadowed.color(x, y) != plain.color(x, y)) ? 1 : 0;
    }
  }
  return result;
}

TEST_CASE("shadows fall where a plain ray tracer has them", "[render]") {
  Shadows all;
  for (unsigned seed = 0; seed < 12; ++seed) {
    RenderRig rig = crowd(seed);
    rig.scene.lights.clear();
    for (RenderGeom& geom : rig.scene.geoms) {
      geom.pattern = RenderPattern::kPlain;
      if (geom.shape == RenderShape::kMesh) std::fill_n(geom.size, 3, 0.1F);  // the mesh's
    }
    for (std::size_t i = 0; i < rig.rgba.size(); ++i) rig.rgba[i] = 1;
    const Vector3f light = Vector3f(0.4F * static_cast<float>(seed) - 2, 1, -1.5F).normalized();
    rig.add_light(light, 0.4F, true);
    const Shadows found = compare_shadows(rig, -light.cast<double>(), 150, 130);
    all.pixels += found.pixels;
    all.dark += found.dark;
    all.wrong += found.wrong;
  }
  CHECK(all.pixels > 100000);
  CHECK(all.dark > 15000);
  CHECK(all.wrong <= all.pixels / 2000);
}

TEST_CASE("infinite planes reach the horizon", "[render]") {
  RenderRig rig;
  rig.add(RenderShape::kPlane, {0, 0, 0}, {0, 0, -1});
  const Image image = rig.render(64, 64);
  CHECK(compare(rig, image, 0.01) == 0);
  CHECK(image.segment[image.at(5, 60)] == 1);
  CHECK(image.segment[image.at(5, 32)] == 1);  // 64 m away
  CHECK(image.segment[image.at(5, 31)] == 0);

  rig.set_camera({0, 0, -2}, look_along({1, 0, 0}, {0, 0, 1}));  // seen from below: nothing
  CHECK(rig.render().segment == std::vector<std::int32_t>(64 * 64, 0));
}

}  // namespace
}  // namespace engram::test
