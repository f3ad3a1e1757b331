#include "render/egl/view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"
#include "render/egl/gl_shaders.h"

namespace engram::gl {
namespace {

using Eigen::Matrix3f;
using Eigen::Vector3f;
using Rotation = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;
using Position = Eigen::Map<const Vector3f>;

constexpr int kNotDrawn = -1;
constexpr int kOutOfSight = -1;
constexpr int kLightLevel = 4;  // shadows need no exact outlines

bool is_round(RenderShape shape) {
  return shape != RenderShape::kBox && shape != RenderShape::kPlane && shape != RenderShape::kMesh;
}

bool has_pattern(const RenderGeom& geom) {
  return geom.pattern != RenderPattern::kPlain &&
         (geom.shape == RenderShape::kPlane || geom.shape == RenderShape::kBox);
}

// Half extents of the box around a geom, in its frame; of a mesh, around its origin.
Vector3f half_extents(const RenderScene& scene, const RenderGeom& geom) {
  const float* size = geom.size;
  switch (geom.shape) {
    case RenderShape::kSphere:
      return Vector3f::Constant(size[0]);
    case RenderShape::kCapsule:
      return {size[0], size[0], size[0] + size[1]};
    case RenderShape::kCylinder:
      return {size[0], size[0], size[1]};
    case RenderShape::kMesh: {
      const auto& vertices = scene.meshes[static_cast<std::size_t>(geom.mesh)].vertices;
      const Eigen::Map<const Eigen::Matrix3Xf> points(
          vertices.data(), 3, static_cast<Eigen::Index>(vertices.size() / 3));
      return points.cwiseAbs().rowwise().maxCoeff();
    }
    case RenderShape::kPlane:
    case RenderShape::kEllipsoid:
    case RenderShape::kBox:
      return {size[0], size[1], size[2]};
  }
  return Vector3f::Zero();
}

bool is_shown(const RenderInstances& rows, std::size_t geom) {
  return rows.geom_visible[geom] != 0 && rows.geom_rgba[4 * geom + 3] > 0;
}

// Scale of the shape of size 1, and half the length between a capsule's ends.
void set_scale(const RenderGeom& geom, const float* pose, const Viewpoint* view, float* scale) {
  const float* size = geom.size;
  switch (geom.shape) {
    case RenderShape::kSphere:
    case RenderShape::kCapsule:
      scale[0] = scale[1] = scale[2] = size[0];
      scale[3] = geom.shape == RenderShape::kCapsule ? size[1] : 0;
      return;
    case RenderShape::kCylinder:
      scale[0] = scale[1] = size[0];
      scale[2] = size[1];
      return;
    case RenderShape::kEllipsoid:
    case RenderShape::kBox:
      std::copy_n(size, 3, scale);
      return;
    case RenderShape::kPlane: {
      std::copy_n(size, 2, scale);
      scale[2] = 1;
      if (view == nullptr) return;
      // Infinite sides reach as far as the camera sees.
      const Vector3f offset = view->position - Position(pose + 9);
      const auto slant = static_cast<float>(real::hypot(1, view->slope_x, view->slope_y));
      const float reach = 1.1F * view->far_clip * slant;
      for (int k = 0; k < 2; ++k) {
        if (size[k] <= 0) scale[k] = std::abs(Rotation(pose).col(k).dot(offset)) + reach;
      }
      return;
    }
    case RenderShape::kMesh:
      scale[0] = scale[1] = scale[2] = 1;
      return;
  }
}

void set_instance(const RenderGeom& geom, const RenderInstances& rows, std::size_t index,
                  const Viewpoint* view, Instance& out) {
  const float* pose = rows.geom_pose + 12 * index;
  for (int k = 0; k < 3; ++k) {
    std::copy_n(pose + 3 * k, 3, out.row[k]);
    out.row[k][3] = pose[9 + k];
  }
  out.scale[3] = 0;
  set_scale(geom, pose, view, out.scale);
  std::copy_n(rows.geom_rgba + 4 * index, 3, out.color);
  out.color[3] = rows.geom_emission[index];
  out.kind[0] = geom.segment;
  out.kind[1] = 0;
  if (geom.shape == RenderShape::kPlane) {
    out.kind[1] = kPlaneBit | (geom.size[1] > geom.size[0] ? kSwapBit : 0);
  }
  if (!has_pattern(geom)) return;
  RenderSurface shown{geom.pattern};
  if (rows.geom_surface != nullptr) shown = rows.geom_surface[index];
  out.scale[3] = shown.scale;  // of the pattern: such geoms have no ends that need it
  out.kind[1] |= static_cast<int>(shown.pattern) | (shown.turned ? kTurnBit : 0);
}

}  // namespace

Viewpoint camera_viewpoint(const RenderScene& scene, const RenderInstances& rows, int camera_index,
                           int width, int height) {
  const auto index = static_cast<std::size_t>(camera_index);
  const RenderCamera& camera = scene.cameras[index];
  const float* pose = rows.camera_pose + 12 * index;
  const float fovy = rows.camera_fovy == nullptr ? camera.fovy : rows.camera_fovy[index];
  Viewpoint view;
  view.axes = Rotation(pose);
  view.position = Position(pose + 9);
  view.slope_y = std::tan(fovy / 2);
  view.slope_x = view.slope_y * static_cast<float>(width) / static_cast<float>(height);
  view.near_clip = camera.near_clip;
  view.far_clip = camera.far_clip;
  view.pixels = static_cast<float>(height) / (2 * view.slope_y);

  Eigen::Matrix4f from_world = Eigen::Matrix4f::Identity();
  from_world.topLeftCorner<3, 3>() = view.axes.transpose();
  from_world.topRightCorner<3, 1>() = -(view.axes.transpose() * view.position);
  const float depth = view.far_clip - view.near_clip;
  Eigen::Matrix4f projection = Eigen::Matrix4f::Zero();
  projection(0, 0) = 1 / view.slope_x;
  projection(1, 1) = -1 / view.slope_y;
  projection(2, 2) = -(view.far_clip + view.near_clip) / depth;
  projection(2, 3) = -2 * view.far_clip * view.near_clip / depth;
  projection(3, 2) = -1;
  view.clip_from_world = projection * from_world;
  return view;
}

DrawList::DrawList(const RenderScene& scene, const Shapes& shapes)
    : scene_(scene), shapes_(shapes) {
  for (const RenderGeom& geom : scene.geoms) half_.push_back(half_extents(scene, geom));
  group_.resize(scene.geoms.size());
  begin_.resize(2 * shapes.parts().size() + 1);
  instances_.reserve(scene.geoms.size());
  draws_.reserve(2 * shapes.parts().size());
}

Viewpoint DrawList::light_viewpoint(const RenderInstances& rows, const Vector3f& to_light,
                                    float& width) const {
  Matrix3f axes;
  axes.col(0) = to_light.unitOrthogonal();
  axes.col(1) = to_light.cross(axes.col(0));
  axes.col(2) = to_light;
  Vector3f low = Vector3f::Constant(std::numeric_limits<float>::max());
  Vector3f high = -low;
  for (std::size_t i = 0; i < scene_.geoms.size(); ++i) {
    if (!is_shown(rows, i) || scene_.geoms[i].shape == RenderShape::kPlane) continue;
    const float* pose = rows.geom_pose + 12 * i;
    const Vector3f center = axes.transpose() * Position(pose + 9);
    const Vector3f half = (axes.transpose() * Rotation(pose)).cwiseAbs() * half_[i];
    low = low.cwiseMin(center - half);
    high = high.cwiseMax(center + half);
  }
  constexpr float kMin = 0.1F;
  if (low.x() > high.x()) low = high = Vector3f::Zero();
  width = std::max(1.02F * (high - low).maxCoeff(), kMin);

  Viewpoint view = {};
  const Vector3f middle = 0.5F * (low + high);
  const float scale = 2 / width;
  view.clip_from_world.setIdentity();
  view.clip_from_world.topLeftCorner<3, 3>() = scale * axes.transpose();
  view.clip_from_world.topRightCorner<3, 1>() = -scale * middle;
  view.clip_from_world.row(2).head<3>() *= -1;  // near is towards the light
  view.clip_from_world(2, 3) *= -1;
  return view;
}

// The level of a round geom, or kOutOfSight.
int DrawList::level_of(std::size_t geom, const float* pose, const Viewpoint& view,
                       float tolerance) const {
  const RenderGeom& shape = scene_.geoms[geom];
  if (shape.shape == RenderShape::kPlane) return 0;
  const Vector3f& half = half_[geom];
  // The polygons' corners are a little outside of the round outline.
  const float radius = 1.03F * half.norm();
  const Vector3f center = view.axes.transpose() * (Position(pose + 9) - view.position);
  const float depth = -center.z();
  if (depth < view.near_clip - radius || depth > view.far_clip + radius) return kOutOfSight;
  const float out_x = std::abs(center.x()) - view.slope_x * depth;
  const float out_y = std::abs(center.y()) - view.slope_y * depth;
  if (out_x > radius * static_cast<float>(real::hypot(1, view.slope_x)) ||
      out_y > radius * static_cast<float>(real::hypot(1, view.slope_y))) {
    return kOutOfSight;
  }
  if (!is_round(shape.shape)) return 0;
  const bool round = shape.shape == RenderShape::kCapsule || shape.shape == RenderShape::kCylinder;
  const float curve = round ? shape.size[0] : half.maxCoeff();
  const float nearest = std::max(depth - half.norm(), std::max(view.near_clip, 0.2F * depth));
  return level_for(curve / nearest * view.pixels, tolerance);
}

void DrawList::fill_for_camera(const RenderInstances& rows, const Viewpoint& view,
                               float tolerance) {
  for (std::size_t i = 0; i < group_.size(); ++i) {
    group_[i] = kNotDrawn;
    if (!is_shown(rows, i)) continue;
    const int level = level_of(i, rows.geom_pose + 12 * i, view, tolerance);
    if (level != kOutOfSight) group_[i] = group_of(i, level);
  }
  sort_out(rows, &view);
}

void DrawList::fill_for_light(const RenderInstances& rows) {
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const RenderGeom& geom = scene_.geoms[i];
    const bool casts = is_shown(rows, i) && geom.shape != RenderShape::kPlane;
    group_[i] = casts ? group_of(i, kLightLevel) : kNotDrawn;
  }
  sort_out(rows, nullptr);
}

int DrawList::group_of(std::size_t geom, int level) const {
  const RenderGeom& shape = scene_.geoms[geom];
  const int part = shapes_.part_of(shape, level);
  return has_pattern(shape) ? part + static_cast<int>(shapes_.parts().size()) : part;
}

// A counting sort by group.
void DrawList::sort_out(const RenderInstances& rows, const Viewpoint* view) {
  std::fill(begin_.begin(), begin_.end(), 0);
  for (const int group : group_) {
    if (group != kNotDrawn) ++begin_[static_cast<std::size_t>(group) + 1];
  }
  draws_.clear();
  const std::size_t parts = shapes_.parts().size();
  for (std::size_t group = 0; group + 1 < begin_.size(); ++group) {
    const int count = begin_[group + 1];
    const bool patterned = group >= parts;
    const auto part = static_cast<int>(patterned ? group - parts : group);
    if (count > 0) draws_.push_back({part, patterned, begin_[group], count});
    begin_[group + 1] += begin_[group];
  }
  instances_.resize(static_cast<std::size_t>(begin_.back()));
  for (std::size_t i = 0; i < group_.size(); ++i) {
    if (group_[i] == kNotDrawn) continue;
    const int at = begin_[static_cast<std::size_t>(group_[i])]++;
    set_instance(scene_.geoms[i], rows, i, view, instances_[static_cast<std::size_t>(at)]);
  }
}

}  // namespace engram::gl
