// Primitive of each shape: bounds of w, screen rectangle, occluder.
#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"
#include "render/cpu/frame_builder.h"

namespace engram::cpu {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

Affine affine(const Vector3d& f) {
  return {static_cast<float>(f.x()), static_cast<float>(f.y()), static_cast<float>(f.z())};
}

// Bound of w by the plane normal . p = distance. A camera in the plane counts as just behind it.
Affine plane_bound(const Vector3d& normal, double distance) {
  return affine(normal / (std::abs(distance) < 1e-7 ? 1e-7 : distance));
}

void set_form(const Matrix3d& form, Occluder& occluder) {
  const double values[] = {form(0, 0), form(1, 1), form(2, 2), form(0, 1), form(0, 2), form(1, 2)};
  for (int i = 0; i < 6; ++i) occluder.form[i] = static_cast<float>(values[i]);
}

void set_occluder(const Vector3d& center, double radius, Occluder& occluder) {
  occluder = Occluder{};
  for (int k = 0; k < 3; ++k) occluder.center[k] = static_cast<float>(center[k]);
  occluder.radius = static_cast<float>(radius);
}

void set_bar(const Vector3d& axis, double half_length, double radius, Occluder& occluder) {
  for (int k = 0; k < 3; ++k) occluder.axis[k] = static_cast<float>(axis[k]);
  occluder.half_length = static_cast<float>(half_length);
  occluder.end = static_cast<float>(1 / (radius * radius));
}

// The axes of a flat round cap.
Matrix3d disc(const Matrix3d& axes, double radius) {
  Matrix3d half = axes * radius;
  half.col(2).setZero();
  return half;
}

}  // namespace

// Sorts a face into those that face the camera, which get a surface, and the others.
void FrameBuilder::add_face(const PlacedGeom& placed, const Vector3d& normal, double distance,
                            ScreenPrimitive& primitive, Affine* fronts, Affine* backs) {
  if (distance <= -1e-7) {
    fronts[primitive.front_count++] = plane_bound(normal, distance);
    add_flat(placed, normal);
  } else {
    backs[-primitive.back_count++] = plane_bound(normal, distance);
  }
}

bool FrameBuilder::add_box(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const float* size = placed.geom->size;
  const Vector3d half(size[0], size[1], size[2]);
  set_occluder(placed.center, half.norm(), primitive.occluder);
  primitive.kind = PrimitiveKind::kConvex;
  primitive.front_count = 0;
  primitive.back_count = 0;
  primitive.rect = rect_of_box(placed.center, placed.axes * half.asDiagonal());
  if (primitive.rect.x0 >= primitive.rect.x1 && !frame_.shadows) return false;

  Affine* planes = &planes_[plane_count_];
  plane_count_ += 6;
  primitive.planes = planes;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d direction = placed.axes.col(axis);
    const double middle = direction.dot(placed.center);
    for (const double sign : {1.0, -1.0}) {
      const Vector3d normal = sign * direction;
      const double distance = sign * middle + half[axis];
      if (distance > -1e-7 || placed.geom->pattern == RenderPattern::kPlain) {
        add_face(placed, normal, distance, primitive, planes, planes + 5);
        continue;
      }
      // Patterns run along the longer side of the face.
      int along = (axis + 1) % 3;
      int across = (axis + 2) % 3;
      if (half[across] > half[along]) std::swap(along, across);
      const Affine bound = plane_bound(normal, distance);
      planes[primitive.front_count++] = bound;
      add_patterned(placed, normal, bound, along, across);
    }
  }
  return primitive.front_count > 0;
}

bool FrameBuilder::add_mesh(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const Hull& hull = prepared_->hulls[static_cast<std::size_t>(placed.geom->mesh)];
  const Vector3d center = placed.center + placed.axes * hull.center;
  set_occluder(center, hull.half.norm(), primitive.occluder);
  primitive.kind = PrimitiveKind::kConvex;
  primitive.front_count = 0;
  primitive.back_count = 0;
  primitive.rect = rect_of_box(center, placed.axes * hull.half.asDiagonal());
  if (primitive.rect.x0 >= primitive.rect.x1 && !frame_.shadows) return false;

  const std::size_t count = hull.offsets.size();
  Affine* planes = &planes_[plane_count_];
  plane_count_ += count;
  primitive.planes = planes;
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3d normal = placed.axes * hull.normals[i];
    add_face(placed, normal, normal.dot(placed.center) + hull.offsets[i], primitive, planes,
             planes + count - 1);
  }
  return primitive.front_count > 0;
}

bool FrameBuilder::add_ball(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const float* size = placed.geom->size;
  const bool sphere = placed.geom->shape == RenderShape::kSphere;
  const Vector3d radii = sphere ? Vector3d::Constant(size[0]) : Vector3d(size[0], size[1], size[2]);
  const Matrix3d half_axes = placed.axes * radii.asDiagonal();
  const Matrix3d scaled = placed.axes * radii.cwiseInverse().asDiagonal();
  const Matrix3d form = scaled * scaled.transpose();
  set_occluder(placed.center, radii.maxCoeff(), primitive.occluder);
  set_form(form, primitive.occluder);
  primitive.kind = PrimitiveKind::kBall;
  Extent extent;
  primitive.rect = include_ball(placed.center, half_axes, extent)
                       ? to_pixels(extent)
                       : rect_of_box(placed.center, half_axes);
  if (primitive.rect.x0 >= primitive.rect.x1) return false;
  if (placed.center.dot(form * placed.center) <= 1) return false;  // the camera is inside
  primitive.conic[0] = make_conic(form, placed.center, 1, primitive.rect);
  if (sphere) {
    add_round(placed, Matrix3d::Identity() / radii[0], placed.center);
  } else {
    add_ellipsoid(placed, form);
  }
  return true;
}

bool FrameBuilder::add_capsule(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const double radius = placed.geom->size[0];
  const double half_length = placed.geom->size[1];
  const Vector3d axis = placed.axes.col(2);
  const Vector3d ends[2] = {placed.center + half_length * axis, placed.center - half_length * axis};
  const Matrix3d across = Matrix3d::Identity() - axis * axis.transpose();
  set_occluder(placed.center, radius + half_length, primitive.occluder);
  set_form(across / (radius * radius), primitive.occluder);
  set_bar(axis, half_length, radius, primitive.occluder);
  primitive.kind = PrimitiveKind::kCapsule;

  Extent extent;
  const Matrix3d ball = placed.axes * radius;
  if (include_ball(ends[0], ball, extent) && include_ball(ends[1], ball, extent)) {
    primitive.rect = to_pixels(extent);  // the side lies between its ends
  } else {
    const Vector3d half(radius, radius, radius + half_length);
    primitive.rect = rect_of_box(placed.center, placed.axes * half.asDiagonal());
  }
  if (primitive.rect.x0 >= primitive.rect.x1) return false;

  const double along = -axis.dot(placed.center);  // of the camera
  const double nearest = std::clamp(along, -half_length, half_length);
  if ((placed.center + nearest * axis).norm() <= radius) return false;  // the camera is inside
  primitive.conic[0] = make_conic(across, placed.center, radius * radius, primitive.rect);
  if ((across * placed.center).norm() <= radius) {  // an end alone faces the camera
    primitive.conic[0] = Conic{};
    primitive.conic[0].one = -1;
  }
  for (int i = 0; i < 2; ++i) {
    primitive.conic[i + 1] =
        make_conic(Matrix3d::Identity(), ends[i], radius * radius, primitive.rect);
  }
  primitive.local[0] = affine(axis);
  primitive.offset[0] = static_cast<float>(along);
  primitive.limit[0] = static_cast<float>(half_length);
  add_round(placed, across / radius, placed.center);
  add_round(placed, Matrix3d::Identity() / radius, ends[0]);
  add_round(placed, Matrix3d::Identity() / radius, ends[1]);
  return true;
}

bool FrameBuilder::add_cylinder(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const double radius = placed.geom->size[0];
  const double half_length = placed.geom->size[1];
  const Vector3d axis = placed.axes.col(2);
  const Matrix3d across = Matrix3d::Identity() - axis * axis.transpose();
  set_occluder(placed.center, real::hypot(radius, half_length), primitive.occluder);
  set_form(across / (radius * radius), primitive.occluder);
  set_bar(axis, half_length, radius, primitive.occluder);
  primitive.kind = PrimitiveKind::kCylinder;

  Extent extent;
  const Matrix3d cap = disc(placed.axes, radius);
  if (include_ball(placed.center + half_length * axis, cap, extent) &&
      include_ball(placed.center - half_length * axis, cap, extent)) {
    primitive.rect = to_pixels(extent);
  } else {
    const Vector3d half(radius, radius, half_length);
    primitive.rect = rect_of_box(placed.center, placed.axes * half.asDiagonal());
  }
  if (primitive.rect.x0 >= primitive.rect.x1) return false;

  // Caps: at most one faces the camera; it comes first.
  const double middle = axis.dot(placed.center);
  const double top = middle + half_length;
  const double bottom = half_length - middle;
  const bool from_above = top <= -1e-7;
  const bool from_below = bottom <= -1e-7;
  primitive.front_count = from_above || from_below ? 1 : 0;
  primitive.back_count = 2 - primitive.front_count;
  Affine* planes = &planes_[plane_count_];
  plane_count_ += 2;
  primitive.planes = planes;
  planes[from_below ? 1 : 0] = plane_bound(axis, top);
  planes[from_below ? 0 : 1] = plane_bound(-axis, bottom);

  const Vector3d off_axis = across * placed.center;
  primitive.camera_within_side = off_axis.squaredNorm() - radius * radius < 1e-9 * radius * radius;
  if (primitive.camera_within_side && primitive.front_count == 0) return false;  // inside
  primitive.conic[0] = make_conic(across, placed.center, radius * radius, primitive.rect);
  add_round(placed, across / radius, placed.center);
  if (primitive.front_count > 0) add_flat(placed, from_above ? axis : -axis);
  return true;
}

bool FrameBuilder::add_plane(const PlacedGeom& placed, ScreenPrimitive& primitive) {
  const float* size = placed.geom->size;
  constexpr double kInfinite = 1e9;
  const Vector3d normal = placed.axes.col(2);
  const double distance = normal.dot(placed.center);
  primitive.kind = PrimitiveKind::kPlane;
  set_occluder(placed.center, kInfinite, primitive.occluder);
  if (distance > -1e-7) return false;  // the camera is below

  const bool bounded = size[0] > 0 && size[1] > 0;
  const Vector3d half(size[0], size[1], 0);
  primitive.rect = bounded ? rect_of_box(placed.center, placed.axes * half.asDiagonal()) : screen();
  if (primitive.rect.x0 >= primitive.rect.x1) return false;
  Affine* plane = &planes_[plane_count_++];
  *plane = plane_bound(normal, distance);
  primitive.planes = plane;
  primitive.front_count = 1;
  primitive.back_count = 0;
  for (int k = 0; k < 2; ++k) {
    primitive.local[k] = affine(placed.axes.col(k));
    primitive.offset[k] = static_cast<float>(-placed.axes.col(k).dot(placed.center));
    primitive.limit[k] = size[k] > 0 ? size[k] : static_cast<float>(kInfinite);
  }
  if (placed.geom->pattern == RenderPattern::kPlain) {
    add_flat(placed, normal);
  } else {
    const int along = half.y() > half.x() ? 1 : 0;
    add_patterned(placed, normal, *plane, along, 1 - along);
  }
  return true;
}

}  // namespace engram::cpu
