// Builds the frame that the kernels draw: one environment in the view of one camera.
#pragma once

#include <Eigen/Dense>
#include <span>
#include <utility>
#include <vector>

#include "core/base/aligned_array.h"
#include "core/image/renderer.h"
#include "render/cpu/frame_data.h"
#include "render/cpu/geom_batch.h"
#include "render/cpu/prepared_scene.h"

namespace engram::cpu {

// A geom in camera axes (right, up, forward), the camera at the origin.
struct PlacedGeom {
  const RenderGeom* geom;
  const float* rgba;
  float emission;
  const RenderSurface* surface;  // or null
  Eigen::Vector3d center;
  Eigen::Matrix3d axes;  // its columns: the geom's axes
};

// A range of u and v; empty to begin with.
struct Extent {
  double low[2] = {1e30, 1e30};
  double high[2] = {-1e30, -1e30};
};

inline bool operator<(const Rank& a, const Rank& b) {
  return a.depth < b.depth || (a.depth == b.depth && a.geom < b.geom);
}

// The geoms in a frame: those that never move, the others, or all.
enum class Shown { kAll, kStill, kMoving };

// Part of one thread's Workspace (cpu_renderer.cc): the frame, and the memory that it points to.
class FrameBuilder {
 public:
  // `max_width` and `max_height` are those of frames, in samples.
  // Without `setup`, all geoms are projected one by one, which gives the same frame.
  FrameBuilder(const PreparedScene& prepared, const SetupKernel* setup, int max_width,
               int max_height);

  // Does not allocate.
  const FrameData& build(const RenderInstances& instances, int camera, int width, int height,
                         Shown shown = Shown::kAll);
  // The frame with segments for colours: nothing of it is shaded. Valid until the next build.
  const FrameData& segmented();
  // Ranks of the frame's primitives, from near to far.
  std::span<const Rank> ranks() const {
    return {ranks_.data(), static_cast<std::size_t>(primitive_count_)};
  }

 private:
  bool sort_by_count();
  void sort();
  void set_casters();
  void aim(const RenderInstances& instances, int camera, int width, int height);
  void set_lights(const RenderLighting* lighting);
  void add_background();
  bool is_shown(const RenderInstances& instances, std::size_t index, Shown shown) const {
    if (instances.geom_visible != nullptr && instances.geom_visible[index] == 0) return false;
    if (!(instances.geom_rgba[4 * index + 3] > 0)) return false;
    return shown == Shown::kAll || prepared_->scene.geoms[index].still == (shown == Shown::kStill);
  }
  // False only if the geom's bounding ball is out of sight.
  bool may_show(const RenderInstances& instances, std::size_t index) const;
  PlacedGeom place(const RenderInstances& instances, std::size_t index) const;
  void add(const PlacedGeom& placed, std::size_t geom);
  // The last step: the primitive counts from now on. `shaded`: one of its surfaces has no single
  // colour. `depth`: of its nearest point, or less.
  void keep(ScreenPrimitive& primitive, bool shaded, float depth, std::size_t geom);

  // Adds all geoms, a batch of one shape at a time where that is possible
  // (frame_builder_batches.cc).
  void add_batches(const RenderInstances& instances, Shown shown);
  std::size_t find_pending(const RenderInstances& instances, Shown shown,
                           std::span<const int> geoms);
  void add_boxes(const RenderInstances& instances, std::span<const int> geoms);
  void add_capsules(const RenderInstances& instances, std::span<const int> geoms);
  void add_cylinders(const RenderInstances& instances, std::span<const int> geoms);
  ScreenPrimitive& begin(PrimitiveKind kind, const Visibility& visibility, std::size_t lane);
  void add_colored(std::size_t geom, std::uint32_t code);
  Surface& add_lit(std::size_t geom, const RoundLight& lit, std::size_t lane);

  // Shapes. Each returns whether the camera can see any of it.
  bool add_box(const PlacedGeom& placed, ScreenPrimitive& primitive);
  bool add_mesh(const PlacedGeom& placed, ScreenPrimitive& primitive);
  bool add_ball(const PlacedGeom& placed, ScreenPrimitive& primitive);
  bool add_capsule(const PlacedGeom& placed, ScreenPrimitive& primitive);
  bool add_cylinder(const PlacedGeom& placed, ScreenPrimitive& primitive);
  bool add_plane(const PlacedGeom& placed, ScreenPrimitive& primitive);

  // Screen rectangles.
  Rect screen() const { return {0, width_, 0, height_}; }
  Rect rect_of_box(const Eigen::Vector3d& center, const Eigen::Matrix3d& half_axes) const;
  // Adds points center + half_axes x with |x| <= 1; false if some are before the near plane.
  bool include_ball(const Eigen::Vector3d& center, const Eigen::Matrix3d& half_axes,
                    Extent& extent) const;
  Rect to_pixels(const Extent& extent) const;
  Conic make_conic(const Eigen::Matrix3d& form, const Eigen::Vector3d& center, double level,
                   const Rect& rect) const;

  // Surfaces.
  Surface& new_surface(const PlacedGeom& placed);
  void add_flat(const PlacedGeom& placed, const Eigen::Vector3d& normal);
  void add_patterned(const PlacedGeom& placed, const Eigen::Vector3d& normal, const Affine& plane,
                     int along, int across);
  void add_round(const PlacedGeom& placed, const Eigen::Matrix3d& normal_of,
                 const Eigen::Vector3d& center);
  void add_ellipsoid(const PlacedGeom& placed, const Eigen::Matrix3d& form);
  void light_flat(const Eigen::Vector3d& normal, Surface& surface) const;
  int add_gloss(const Eigen::Vector3d& normal);
  void add_face(const PlacedGeom& placed, const Eigen::Vector3d& normal, double distance,
                ScreenPrimitive& primitive, Affine* fronts, Affine* backs);

  const PreparedScene* prepared_;
  const SetupKernel* setup_;
  ViewParams view_params_ = {};
  FrameData frame_ = {};
  Eigen::Matrix3d world_to_camera_;
  Eigen::Vector3d eye_;
  std::vector<Eigen::Vector3d> lights_;  // unit, towards each, camera axes
  const RenderLight* light_colors_ = nullptr;
  const float* ambient_ = nullptr;
  double near_ = 0;
  double half_u_ = 0;
  double half_v_ = 0;
  int width_ = 0;
  int height_ = 0;
  AlignedArray<float> u_;
  AlignedArray<float> v_;
  AlignedArray<float> left_;  // u of blocks
  AlignedArray<float> right_;
  std::vector<ScreenPrimitive> primitives_;
  std::vector<const ScreenPrimitive*> order_;
  std::vector<Rect> rects_;  // in their order
  std::vector<Rank> ranks_;
  std::vector<Rank> unsorted_;  // of the primitives as they come
  AlignedArray<float> depths_;  // theirs
  AlignedArray<std::int32_t> nearer_;
  AlignedArray<std::int32_t> tops_;  // of `rects_`, in whole blocks
  AlignedArray<std::int32_t> bottoms_;
  std::vector<Surface> surfaces_;
  std::vector<std::uint32_t> codes_;
  std::vector<std::uint32_t> segments_;
  FrameData segmented_ = {};
  std::vector<Gloss> glosses_;
  AlignedArray<float> gloss_rows_;
  AlignedArray<float> caster_rows_;  // of Casters, one after the other
  std::vector<Affine> planes_;
  std::vector<int> pending_;  // geoms for the next batches
  std::size_t plane_count_ = 0;
  int primitive_count_ = 0;
  int surface_count_ = 0;
};

}  // namespace engram::cpu
