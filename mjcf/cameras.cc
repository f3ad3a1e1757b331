#include "mjcf/cameras.h"

#include <cstddef>
#include <numbers>

#include "core/math/real_functions.h"
#include "mjcf/prop.h"

namespace engram::mjcf {
namespace {

constexpr double kSensorFovy = 90;                      // degrees
constexpr double kRenderFovy = 180 / std::numbers::pi;  // one radian

Vec3 unit(const Vec3& v) {
  const double norm = real::hypot(v[0], v[1], v[2]);
  return {v[0] / norm, v[1] / norm, v[2] / norm};
}

Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// Axes of length 1.
void add_camera(Element& body, const char* name, const Vec3& pos, const Vec3& right, const Vec3& up,
                double fovy) {
  const Vec3 back = cross(right, up);
  Mat3 axes;
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    axes.row(i) << right[k], up[k], back[k];
  }
  Element& camera = add(body, "camera");
  set(camera, "name", name);
  set(camera, "pos", pos);
  set_rotation(camera, Eigen::Quaterniond(axes));
  set(camera, "fovy", fovy);
}

// A camera that looks from eye to target with the horizon level.
void add_look_at(Element& world, const char* name, const Vec3& eye, const Vec3& target,
                 double fovy) {
  const Vec3 forward = unit({target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]});
  const Vec3 right = unit(cross(forward, {0, 0, 1}));
  add_camera(world, name, eye, right, cross(right, forward), fovy);
}

void add_render_camera(Element& world, RenderView view) {
  switch (view) {
    case RenderView::kRobotAndTable:
      return add_look_at(world, "render_camera", {0.5, 1, 1}, {-0.3, 0, 0}, kRenderFovy);
    case RenderView::kTable:
      return add_look_at(world, "render_camera", {0.6, 0.7, 0.6}, {0, 0, 0.15}, kRenderFovy);
    case RenderView::kAboveTable:
      return add_look_at(world, "render_camera", {0.6, 0.7, 0.6}, {0, 0, 0.35}, kRenderFovy);
  }
}

}  // namespace

void add_world_cameras(Element& worldbody, RenderView render_view) {
  add_look_at(worldbody, "base_camera", {0.3, 0, 0.6}, {-0.1, 0, 0.1}, kSensorFovy);
  add_render_camera(worldbody, render_view);
}

void add_hand_camera(Element& hand) {
  // Looks along the hand's z axis; up is the hand's x axis.
  add_camera(hand, "hand_camera", {0.046498, -0.020001, 0.036001}, {0, 1, 0}, {1, 0, 0},
             kSensorFovy);
}

}  // namespace engram::mjcf
