#include "render/cpu/frame_builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/math/real_functions.h"

namespace engram::cpu {
namespace {

constexpr int round_up(int value, int unit) { return (value + unit - 1) / unit * unit; }

std::uint32_t pixel_of(const float (&levels)[3]) {
  std::uint32_t pixel = 0;
  for (int k = 0; k < 3; ++k) {
    const float level = std::clamp(levels[k], 0.0F, 255.0F);
    pixel |= static_cast<std::uint32_t>(std::lrint(level)) << (8 * k);
  }
  return pixel;
}

using CameraAxes = Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>>;

}  // namespace

FrameBuilder::FrameBuilder(const PreparedScene& prepared, const SetupKernel* setup, int max_width,
                           int max_height)
    : prepared_(&prepared),
      setup_(setup),
      lights_(prepared.to_light.size()),
      u_(static_cast<std::size_t>(round_up(max_width, kBlock) + kBlock)),
      v_(static_cast<std::size_t>(round_up(max_height, kBlock))),
      left_(static_cast<std::size_t>(round_up(max_width, kBlock * kBlock) / kBlock)),
      right_(left_.size()),
      primitives_(prepared.scene.geoms.size()),
      order_(primitives_.size()),
      rects_(primitives_.size()),
      ranks_(primitives_.size()),
      unsorted_(primitives_.size()),
      depths_(static_cast<std::size_t>(round_up(static_cast<int>(primitives_.size()), kBlock))),
      nearer_(depths_.size()),
      tops_(depths_.size()),
      bottoms_(depths_.size()),
      surfaces_(prepared.max_surfaces),
      codes_(prepared.max_surfaces + 1),  // add_boxes() may write one too many
      segments_(codes_.size()),
      glosses_(prepared.max_glosses),
      gloss_rows_(4 * prepared.max_glosses * u_.size()),
      planes_(prepared.max_planes),
      pending_(prepared.scene.geoms.size()) {
  frame_.u = u_.data();
  frame_.v = v_.data();
  frame_.left = left_.data();
  frame_.right = right_.data();
  frame_.primitives = order_.data();
  frame_.rects = rects_.data();
  frame_.tops = tops_.data();
  frame_.bottoms = bottoms_.data();
  frame_.shades = true;
  frame_.surfaces = surfaces_.data();
  frame_.codes = codes_.data();
  frame_.segments = segments_.data();
  frame_.glosses = glosses_.data();
  for (std::size_t i = 0; i < glosses_.size(); ++i) {
    float* rows = gloss_rows_.data() + 4 * i * u_.size();
    glosses_[i].first = rows;
    glosses_[i].step = rows + u_.size();
    glosses_[i].nodes[0] = rows + 2 * u_.size();
    glosses_[i].nodes[1] = rows + 3 * u_.size();
  }
  frame_.wood = prepared.wood;
  frame_.light_count = static_cast<int>(lights_.size());
  int ray = 0;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    frame_.ray_begin[i] = ray;
    ray += static_cast<int>(prepared.rays[i].size());
    frame_.ray_begin[i + 1] = ray;
  }
  frame_.shadows = ray > 0;
  if (!frame_.shadows) return;
  const auto row = static_cast<std::size_t>(round_up(static_cast<int>(primitives_.size()), kBlock));
  caster_rows_ = AlignedArray<float>(4 * row);
  const float* rows = caster_rows_.data();
  frame_.casters = {rows, rows + row, rows + 2 * row, rows + 3 * row};
}

const FrameData& FrameBuilder::build(const RenderInstances& instances, int camera, int width,
                                     int height, Shown shown) {
  aim(instances, camera, width, height);
  set_lights(instances.lighting);
  plane_count_ = 0;
  primitive_count_ = 0;
  surface_count_ = 0;
  frame_.gloss_count = 0;
  add_background();
  if (setup_ != nullptr && !frame_.shadows) {
    add_batches(instances, shown);
  } else {
    for (std::size_t i = 0; i < prepared_->scene.geoms.size(); ++i) {
      if (is_shown(instances, i, shown) && may_show(instances, i)) add(place(instances, i), i);
    }
  }

  sort();
  frame_.primitive_count = primitive_count_;
  if (frame_.shadows) set_casters();
  return frame_;
}

// Puts `unsorted_` in order into `ranks_`. Counting what is nearer needs no branches. False if that
// does not work, because a depth is no number.
bool FrameBuilder::sort_by_count() {
  constexpr int kFree = -1;
  const auto count = static_cast<std::size_t>(primitive_count_);
  for (std::size_t i = 0; i < count; ++i) {
    depths_[i] = unsorted_[i].depth;
    ranks_[i].primitive = kFree;
  }
  setup_->count_nearer(depths_.data(), primitive_count_, nearer_.data());
  for (std::size_t i = 0; i < count; ++i) {
    Rank rank = unsorted_[i];
    auto place = static_cast<std::size_t>(nearer_[i]);
    // Equally near ones have the same count, and as many places from there on.
    while (ranks_[place].primitive != kFree) {
      if (ranks_[place].depth != rank.depth) return false;
      if (rank < ranks_[place]) std::swap(rank, ranks_[place]);
      if (++place == count) return false;
    }
    ranks_[place] = rank;
  }
  return true;
}

void FrameBuilder::sort() {
  const auto count = static_cast<std::size_t>(primitive_count_);
  if (setup_ == nullptr || !sort_by_count()) {
    std::copy_n(unsorted_.begin(), count, ranks_.begin());
    std::sort(ranks_.begin(), ranks_.begin() + static_cast<std::ptrdiff_t>(count));
  }
  for (std::size_t i = 0; i < count; ++i) {
    order_[i] = &primitives_[static_cast<std::size_t>(ranks_[i].primitive)];
    rects_[i] = order_[i]->rect;
    tops_[i] = rects_[i].y0;
    bottoms_[i] = rects_[i].y1;
  }
  for (std::size_t i = count; i % kBlock != 0; ++i) tops_[i] = bottoms_[i] = 0;  // in no row
}

void FrameBuilder::set_casters() {
  const std::size_t row = caster_rows_.size() / 4;
  constexpr float kNever = -1e30F;
  std::fill(caster_rows_.begin(), caster_rows_.end(), 0.0F);
  std::fill(caster_rows_.end() - static_cast<std::ptrdiff_t>(row), caster_rows_.end(), kNever);
  for (std::size_t i = 0; i < static_cast<std::size_t>(primitive_count_); ++i) {
    if (order_[i]->kind == PrimitiveKind::kPlane) continue;
    const Occluder& occluder = order_[i]->occluder;
    for (std::size_t k = 0; k < 3; ++k) caster_rows_[k * row + i] = occluder.center[k];
    caster_rows_[3 * row + i] = occluder.radius;
  }
}

void FrameBuilder::aim(const RenderInstances& instances, int camera_index, int width, int height) {
  const auto index = static_cast<std::size_t>(camera_index);
  const RenderCamera& camera = prepared_->scene.cameras[index];
  const float* pose = instances.camera_pose + 12 * index;
  const float fovy = instances.camera_fovy == nullptr ? camera.fovy : instances.camera_fovy[index];
  world_to_camera_ = CameraAxes(pose).cast<double>().transpose();
  world_to_camera_.row(2) *= -1;  // cameras look along -z
  eye_ = Eigen::Map<const Eigen::Vector3f>(pose + 9).cast<double>();
  near_ = camera.near_clip;
  frame_.near_w = 1 / camera.near_clip;
  frame_.far_w = 1 / camera.far_clip;

  // Pixel centres.
  const double half_v = real::tan(0.5 * fovy);
  if (width == width_ && height == height_ && half_v == half_v_) return;
  width_ = width;
  height_ = height;
  half_v_ = half_v;
  half_u_ = half_v * width / height;
  frame_.width = width;
  frame_.height = height;
  frame_.pixel = static_cast<float>(2 * half_v / height);
  for (int x = 0; x < round_up(width, kBlock); ++x) {
    u_[static_cast<std::size_t>(x)] = static_cast<float>(((x + 0.5) / width * 2 - 1) * half_u_);
  }
  for (int y = 0; y < round_up(height, kBlock); ++y) {
    v_[static_cast<std::size_t>(y)] = static_cast<float>((1 - (y + 0.5) / height * 2) * half_v_);
  }
  for (int x = 0; x < width; x += kBlock) {
    left_[static_cast<std::size_t>(x / kBlock)] = u_[static_cast<std::size_t>(x)];
    right_[static_cast<std::size_t>(x / kBlock)] = u_[static_cast<std::size_t>(x + kBlock - 1)];
  }
}

void FrameBuilder::set_lights(const RenderLighting* lighting) {
  const RenderScene& scene = prepared_->scene;
  light_colors_ = lighting == nullptr ? scene.lights.data() : lighting->lights.data();
  ambient_ = lighting == nullptr ? scene.ambient : lighting->ambient;
  std::array<Eigen::Vector3d, kMaxRays> own_rays;
  for (std::size_t i = 0; i < lights_.size(); ++i) {
    Eigen::Vector3d to_light = prepared_->to_light[i];
    std::span<const Eigen::Vector3d> rays = prepared_->rays[i];
    if (lighting != nullptr) {
      to_light = -Eigen::Map<const Eigen::Vector3f>(light_colors_[i].direction)
                      .cast<double>()
                      .normalized();
      const std::span<Eigen::Vector3d> own(own_rays.data(), rays.size());
      if (!own.empty()) spread(to_light, prepared_->shadow_softness, own);
      rays = own;
    }
    lights_[i] = world_to_camera_ * to_light;
    for (std::size_t r = 0; r < rays.size(); ++r) {
      const Eigen::Vector3d ray = world_to_camera_ * rays[r];
      float* out = frame_.ray[static_cast<std::size_t>(frame_.ray_begin[i]) + r];
      Eigen::Map<Eigen::Vector3f> mapped(out);
      mapped = ray.cast<float>();
    }
  }
}

void FrameBuilder::add_background() {
  Surface& background = surfaces_[static_cast<std::size_t>(surface_count_++)];
  background = Surface{};
  for (int k = 0; k < 3; ++k) {
    background.constant[k] = std::clamp(prepared_->scene.background[k], 0.0F, 1.0F) * 255;
  }
  codes_[0] = pixel_of(background.constant);
  segments_[0] = 0;
}

bool FrameBuilder::may_show(const RenderInstances& instances, std::size_t index) const {
  if (frame_.shadows) return true;  // a geom out of sight may cast some
  const double radius = prepared_->ball_radius[index];
  if (std::isinf(radius)) return true;
  const float* position = instances.geom_pose + 12 * index + 9;
  const Eigen::Vector3d center =
      world_to_camera_ * (Eigen::Map<const Eigen::Vector3f>(position).cast<double>() - eye_);
  // Distances to the near plane and to the four sides of what the camera sees.
  const double side_u = radius * std::sqrt(1 + half_u_ * half_u_);
  const double side_v = radius * std::sqrt(1 + half_v_ * half_v_);
  return !(center.z() + radius < near_ || std::abs(center.x()) - half_u_ * center.z() > side_u ||
           std::abs(center.y()) - half_v_ * center.z() > side_v);
}

PlacedGeom FrameBuilder::place(const RenderInstances& instances, std::size_t index) const {
  const float* pose = instances.geom_pose + 12 * index;
  PlacedGeom placed;
  placed.geom = &prepared_->scene.geoms[index];
  placed.rgba = instances.geom_rgba + 4 * index;
  placed.emission = instances.geom_emission == nullptr ? 0 : instances.geom_emission[index];
  placed.surface = instances.geom_surface == nullptr ? nullptr : instances.geom_surface + index;
  const Eigen::Vector3d position = Eigen::Map<const Eigen::Vector3f>(pose + 9).cast<double>();
  placed.center = world_to_camera_ * (position - eye_);
  placed.axes = world_to_camera_ * CameraAxes(pose).cast<double>();
  return placed;
}

void FrameBuilder::add(const PlacedGeom& placed, std::size_t geom) {
  if (!placed.center.allFinite() || !placed.axes.allFinite()) return;  // diverged physics
  ScreenPrimitive& primitive = primitives_[static_cast<std::size_t>(primitive_count_)];
  primitive.surface = surface_count_;
  const int glosses = frame_.gloss_count;
  primitive.rect = {0, 0, 0, 0};
  bool visible = false;
  switch (placed.geom->shape) {
    case RenderShape::kPlane:
      visible = add_plane(placed, primitive);
      break;
    case RenderShape::kSphere:
    case RenderShape::kEllipsoid:
      visible = add_ball(placed, primitive);
      break;
    case RenderShape::kCapsule:
      visible = add_capsule(placed, primitive);
      break;
    case RenderShape::kCylinder:
      visible = add_cylinder(placed, primitive);
      break;
    case RenderShape::kBox:
      visible = add_box(placed, primitive);
      break;
    case RenderShape::kMesh:
      visible = add_mesh(placed, primitive);
      break;
  }
  if (primitive.rect.x0 >= primitive.rect.x1) visible = false;
  if (!visible) {
    primitive.rect = {0, 0, 0, 0};
    surface_count_ = primitive.surface;
    frame_.gloss_count = glosses;
    if (!frame_.shadows) return;
  }
  bool shaded = false;
  for (int i = primitive.surface; i < surface_count_; ++i) {
    const Surface& surface = surfaces_[static_cast<std::size_t>(i)];
    const bool even = surface.lighting == Lighting::kConstant && surface.pattern == Pattern::kPlain;
    codes_[static_cast<std::size_t>(i)] =
        even ? pixel_of(surface.constant) : kShaded | static_cast<std::uint32_t>(i);
    shaded |= !even;
  }
  keep(primitive, shaded, primitive.occluder.center[2] - primitive.occluder.radius, geom);
}

void FrameBuilder::keep(ScreenPrimitive& primitive, bool shaded, float depth, std::size_t geom) {
  primitive.surface_count = surface_count_ - primitive.surface;
  primitive.shaded = shaded;
  unsorted_[static_cast<std::size_t>(primitive_count_)] = {depth, static_cast<int>(geom),
                                                           primitive_count_};
  ++primitive_count_;
}

Rect FrameBuilder::to_pixels(const Extent& extent) const {
  // A quarter of a pixel more than needed, so that rounding never cuts a silhouette.
  constexpr double kMargin = 0.25;
  const double columns = 0.5 * width_ / half_u_;
  const double rows = 0.5 * height_ / half_v_;
  const auto column = [&](double u) { return u * columns + (0.5 * width_ - 0.5); };
  const auto row = [&](double v) { return (0.5 * height_ - 0.5) - v * rows; };
  const auto first = [](double at, int size) {
    return static_cast<int>(std::ceil(std::clamp(at - kMargin, 0.0, static_cast<double>(size))));
  };
  const auto last = [](double at, int size) {
    return static_cast<int>(std::floor(std::clamp(at + kMargin, -1.0, size - 1.0))) + 1;
  };
  for (int k = 0; k < 2; ++k) {
    if (!(extent.low[k] <= extent.high[k])) return {0, 0, 0, 0};
  }
  const Rect rect = {first(column(extent.low[0]), width_), last(column(extent.high[0]), width_),
                     first(row(extent.high[1]), height_), last(row(extent.low[1]), height_)};
  if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) return {0, 0, 0, 0};
  return rect;
}

Rect FrameBuilder::rect_of_box(const Eigen::Vector3d& center,
                               const Eigen::Matrix3d& half_axes) const {
  Eigen::Vector3d corners[8];
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d signs((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1,
                                (i & 4) != 0 ? 1 : -1);
    corners[i] = center + half_axes * signs;
  }
  Extent extent;
  const auto include = [&extent](double x, double y, double depth) {
    const double nearness = 1 / depth;
    const double at[2] = {x * nearness, y * nearness};
    for (int k = 0; k < 2; ++k) {
      extent.low[k] = std::min(extent.low[k], at[k]);
      extent.high[k] = std::max(extent.high[k], at[k]);
    }
  };
  bool clipped = false;
  for (const Eigen::Vector3d& p : corners) {
    if (p.z() >= near_) {
      include(p.x(), p.y(), p.z());
    } else {
      clipped = true;
    }
  }
  // Intersections of edges with the near plane.
  for (int i = 0; clipped && i < 8; ++i) {
    for (int axis = 1; axis < 8; axis *= 2) {
      const Eigen::Vector3d& p = corners[i];
      const Eigen::Vector3d& q = corners[i ^ axis];
      if (p.z() < near_ || q.z() >= near_) continue;
      const double t = (p.z() - near_) / (p.z() - q.z());
      include(p.x() + t * (q.x() - p.x()), p.y() + t * (q.y() - p.y()), near_);
    }
  }
  return to_pixels(extent);
}

bool FrameBuilder::include_ball(const Eigen::Vector3d& center, const Eigen::Matrix3d& half_axes,
                                Extent& extent) const {
  const Eigen::Matrix3d m = half_axes * half_axes.transpose();
  if (center.z() - std::sqrt(m(2, 2)) <= near_) return false;
  // Tangents of the dual quadric center center' - m.
  const double a = center.z() * center.z() - m(2, 2);
  for (int k = 0; k < 2; ++k) {
    const double b = center[k] * center.z() - m(k, 2);
    const double c = center[k] * center[k] - m(k, k);
    const double root = std::sqrt(std::max(b * b - a * c, 0.0));
    extent.low[k] = std::min(extent.low[k], (b - root) / a);
    extent.high[k] = std::max(extent.high[k], (b + root) / a);
  }
  return true;
}

// Conic of the points p with (p - center)' form (p - center) <= level. On a ray p = d / w that is
// c w^2 - 2 b w + a <= 0 with b = g . d, a = d' form d. The polynomial under the root is expanded
// around the middle of the rectangle, where it stays accurate in single precision.
Conic FrameBuilder::make_conic(const Eigen::Matrix3d& form, const Eigen::Vector3d& center,
                               double level, const Rect& rect) const {
  const Eigen::Vector3d g = form * center;
  double c = center.dot(g) - level;
  if (std::abs(c) < 1e-9 * level) c = 1e-9 * level;
  const Eigen::Matrix3d q = (g * g.transpose() - c * form) / (c * c);
  const Eigen::Vector3d middle(u_[static_cast<std::size_t>((rect.x0 + rect.x1) / 2)],
                               v_[static_cast<std::size_t>((rect.y0 + rect.y1) / 2)], 1);
  const Eigen::Vector3d slope = 2 * q * middle;
  Conic conic;
  conic.u0 = static_cast<float>(middle.x());
  conic.v0 = static_cast<float>(middle.y());
  conic.bu = static_cast<float>(g.x() / c);
  conic.bv = static_cast<float>(g.y() / c);
  conic.b1 = static_cast<float>(g.dot(middle) / c);
  conic.uu = static_cast<float>(q(0, 0));
  conic.uv = static_cast<float>(2 * q(0, 1));
  conic.vv = static_cast<float>(q(1, 1));
  conic.u = static_cast<float>(slope.x());
  conic.v = static_cast<float>(slope.y());
  conic.one = static_cast<float>(0.5 * slope.dot(middle));
  return conic;
}

}  // namespace engram::cpu
