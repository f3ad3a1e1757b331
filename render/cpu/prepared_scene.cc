#include "render/cpu/prepared_scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/base/error.h"
#include "core/math/real_functions.h"
#include "render/cpu/wood.h"

namespace engram::cpu {
namespace {

[[noreturn]] void refuse(const std::string& message) {
  throw Error(Error::kInvalidArgument, "cpu renderer: " + message);
}

bool all_finite(const float* values, int count) {
  return std::all_of(values, values + count, [](float x) { return std::isfinite(x); });
}

// Number of a shape's sizes that must be above zero.
int size_count(RenderShape shape) {
  switch (shape) {
    case RenderShape::kPlane:
    case RenderShape::kMesh:
      return 0;
    case RenderShape::kSphere:
      return 1;
    case RenderShape::kCapsule:
    case RenderShape::kCylinder:
      return 2;
    case RenderShape::kEllipsoid:
    case RenderShape::kBox:
      return 3;
  }
  refuse("geom of unknown shape " + std::to_string(static_cast<int>(shape)));
}

void check_geom(const RenderScene& scene, std::size_t index) {
  const RenderGeom& geom = scene.geoms[index];
  const std::string name = "geom " + std::to_string(index);
  const int count = size_count(geom.shape);
  if (!all_finite(geom.size, 3)) refuse(name + " has a size that is not finite");
  for (int i = 0; i < count; ++i) {
    if (geom.size[i] <= 0) {
      refuse(name + " has size " + std::to_string(geom.size[i]) + "; must be above 0");
    }
  }
  if (geom.shape == RenderShape::kPlane && (geom.size[0] < 0 || geom.size[1] < 0)) {
    refuse(name + " is a plane of negative size; 0 is infinite");
  }
  const auto meshes = static_cast<int>(scene.meshes.size());
  if (geom.shape == RenderShape::kMesh && (geom.mesh < 0 || geom.mesh >= meshes)) {
    refuse(name + " uses mesh " + std::to_string(geom.mesh) + " of " + std::to_string(meshes));
  }
}

void check_camera(const RenderCamera& camera) {
  const std::string name = "camera '" + camera.name + "'";
  if (!(camera.fovy > 0 && camera.fovy < std::numbers::pi_v<float>)) {
    refuse(name + " has fovy " + std::to_string(camera.fovy) + "; must be in (0, pi) rad");
  }
  if (!(camera.near_clip > 0 && camera.far_clip > camera.near_clip &&
        std::isfinite(camera.far_clip))) {
    refuse(name + " needs 0 < near < far, finite; got " + std::to_string(camera.near_clip) + ", " +
           std::to_string(camera.far_clip));
  }
}

void check(const RenderScene& scene) {
  for (std::size_t i = 0; i < scene.geoms.size(); ++i) check_geom(scene, i);
  for (const RenderCamera& camera : scene.cameras) check_camera(camera);
  if (scene.lights.size() > kMaxLights) {
    refuse(std::to_string(scene.lights.size()) + " lights; at most " + std::to_string(kMaxLights));
  }
  for (const RenderLight& light : scene.lights) {
    if (!all_finite(light.direction, 3) || !all_finite(light.color, 3) ||
        real::hypot(light.direction[0], light.direction[1], light.direction[2]) < 1e-6F) {
      refuse("a light needs a finite colour and a finite direction other than 0");
    }
  }
  if (!all_finite(scene.ambient, 3) || !all_finite(scene.background, 3)) {
    refuse("ambient light and background must be finite");
  }
}

std::size_t plane_count(const RenderGeom& geom, const std::vector<Hull>& hulls) {
  switch (geom.shape) {
    case RenderShape::kMesh:
      return hulls[static_cast<std::size_t>(geom.mesh)].offsets.size();
    case RenderShape::kBox:
      return 6;
    case RenderShape::kCylinder:
      return 2;
    default:
      return 1;
  }
}

// The form that occluders have.
float rank_radius_of(const RenderGeom& geom) {
  const Eigen::Vector3d size = Eigen::Map<const Eigen::Vector3f>(geom.size).cast<double>();
  switch (geom.shape) {
    case RenderShape::kBox:
      return static_cast<float>(size.norm());
    case RenderShape::kCapsule:
      return static_cast<float>(size[0] + size[1]);
    case RenderShape::kCylinder:
      return static_cast<float>(real::hypot(size[0], size[1]));
    default:
      return 0;
  }
}

double ball_radius_of(const RenderGeom& geom) {
  const float* size = geom.size;
  double radius = 0;
  switch (geom.shape) {
    case RenderShape::kSphere:
      radius = size[0];
      break;
    case RenderShape::kCapsule:
      radius = size[0] + size[1];
      break;
    case RenderShape::kCylinder:
      radius = real::hypot(size[0], size[1]);
      break;
    case RenderShape::kEllipsoid:
      radius = std::max(size[0], std::max(size[1], size[2]));
      break;
    case RenderShape::kBox:
      radius = real::hypot(size[0], size[1], size[2]);
      break;
    case RenderShape::kPlane:
    case RenderShape::kMesh:
      return std::numeric_limits<double>::infinity();
  }
  return 1.001 * radius + 1e-6;
}

std::vector<int>& batch_of(PreparedScene& prepared, const RenderGeom& geom) {
  switch (geom.shape) {
    case RenderShape::kBox:
      return geom.pattern == RenderPattern::kPlain ? prepared.boxes : prepared.others;
    case RenderShape::kCapsule:
      return prepared.capsules;
    case RenderShape::kCylinder:
      return prepared.cylinders;
    default:
      return prepared.others;
  }
}

}  // namespace

// A spiral of equal areas.
void spread(const Eigen::Vector3d& axis, double half_angle, std::span<Eigen::Vector3d> directions) {
  const std::size_t count = directions.size();
  if (count == 1) {
    directions[0] = axis;
    return;
  }
  const Eigen::Vector3d x = axis.unitOrthogonal();
  const Eigen::Vector3d y = axis.cross(x);
  const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
  for (std::size_t n = 0; n < count; ++n) {
    const auto i = static_cast<double>(n);
    const double r = real::tan(half_angle) * std::sqrt((i + 0.5) / static_cast<double>(count));
    directions[n] =
        (axis + r * (real::cos(golden * i) * x + real::sin(golden * i) * y)).normalized();
  }
}

Hull make_hull(const RenderMesh& mesh, const std::string& name) {
  const std::size_t points = mesh.vertices.size() / 3;
  if (mesh.vertices.size() % 3 != 0 || mesh.triangles.size() % 3 != 0 || points < 4 ||
      mesh.triangles.size() < 12) {
    refuse(name + " needs at least 4 vertices and 4 triangles of 3 numbers each");
  }
  if (!all_finite(mesh.vertices.data(), static_cast<int>(mesh.vertices.size()))) {
    refuse(name + " has a vertex that is not finite");
  }
  const auto vertex = [&](std::size_t i) -> Eigen::Vector3d {
    return Eigen::Map<const Eigen::Vector3f>(&mesh.vertices[3 * i]).cast<double>();
  };

  Eigen::Vector3d low = vertex(0);
  Eigen::Vector3d high = low;
  for (std::size_t i = 1; i < points; ++i) {
    low = low.cwiseMin(vertex(i));
    high = high.cwiseMax(vertex(i));
  }
  Hull hull;
  hull.center = 0.5 * (low + high);
  hull.half = 0.5 * (high - low);
  const double size = hull.half.norm();

  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    Eigen::Vector3d corner[3];
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t index = mesh.triangles[t + k];
      if (index < 0 || static_cast<std::size_t>(index) >= points) {
        refuse(name + " has a triangle of vertex " + std::to_string(index) + " of " +
               std::to_string(points));
      }
      corner[k] = vertex(static_cast<std::size_t>(index));
    }
    Eigen::Vector3d normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
    if (normal.norm() < 1e-9 * size * size) continue;  // a sliver has no plane
    normal.normalize();
    const double offset = normal.dot((corner[0] + corner[1] + corner[2]) / 3);
    bool known = false;
    for (std::size_t i = 0; i < hull.offsets.size() && !known; ++i) {
      known = hull.normals[i].dot(normal) > 1 - 1e-6 &&
              std::abs(hull.offsets[i] - offset) < 1e-4 * size;
    }
    if (known) continue;
    for (std::size_t i = 0; i < points; ++i) {
      if (normal.dot(vertex(i)) > offset + 1e-3 * size) refuse(name + " is not convex");
    }
    hull.normals.push_back(normal);
    hull.offsets.push_back(offset);
  }
  if (hull.offsets.size() < 4) refuse(name + " encloses no volume");
  return hull;
}

PreparedScene::PreparedScene(const RenderScene& from, const CpuRendererOptions& options)
    : scene(from), shadow_softness(options.shadow_softness) {
  check(scene);
  for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
    hulls.push_back(make_hull(scene.meshes[i], "mesh " + std::to_string(i)));
  }

  std::size_t ray_count = 0;
  for (const RenderLight& light : scene.lights) {
    const Eigen::Vector3d direction =
        -Eigen::Map<const Eigen::Vector3f>(light.direction).cast<double>().normalized();
    to_light.push_back(direction);
    rays.emplace_back();
    if (light.casts_shadow && options.shadow_rays > 0) {
      rays.back().resize(static_cast<std::size_t>(options.shadow_rays));
      spread(direction, shadow_softness, rays.back());
    }
    ray_count += rays.back().size();
  }
  if (ray_count > kMaxRays) {
    refuse(std::to_string(ray_count) + " shadow rays for all lights; at most " +
           std::to_string(kMaxRays));
  }

  max_surfaces = 1;
  for (const RenderGeom& geom : scene.geoms) {
    const std::size_t planes = plane_count(geom, hulls);
    const std::size_t surfaces = geom.shape == RenderShape::kMesh ? planes : 3;
    max_planes += planes;
    ball_radius.push_back(ball_radius_of(geom));
    rank_radius.push_back(rank_radius_of(geom));
    max_surfaces += surfaces;  // at most three faces of a box are visible
    if (geom.pattern != RenderPattern::kPlain) max_glosses += 3;  // an environment's may be wood
    batch_of(*this, geom).push_back(static_cast<int>(ball_radius.size()) - 1);
  }
  const bool patterns = std::any_of(scene.geoms.begin(), scene.geoms.end(), [](const auto& geom) {
    return geom.pattern != RenderPattern::kPlain;
  });
  if (patterns) wood = wood_texture();
}

bool PreparedScene::casts_shadows() const {
  return std::any_of(rays.begin(), rays.end(),
                     [](const auto& of_light) { return !of_light.empty(); });
}

}  // namespace engram::cpu
