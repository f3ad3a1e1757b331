#include "mjcf/shapes.h"

#include <array>
#include <numbers>
#include <vector>

#include "core/math/real_functions.h"
#include "mjcf/footing.h"
#include "mjcf/inertia.h"

namespace engram::mjcf {
namespace {

// All sizes follow from one length, SHAPE_SCALE: `scale`, m.
constexpr double kPi = std::numbers::pi;

using Primitives = std::vector<Primitive>;

// Half the width of a cross, and half the thickness of star and t_shape.
double thick_half(double scale) { return 0.5 * (0.75 * scale); }

Primitive box(const Vec3& half, const Vec3& pos = {}) {
  return {.shape = Shape::kBox, .size = half, .pos = pos};
}

// An upright disc or post.
Primitive disc(double radius, double half_length, const Vec3& pos = {}) {
  return {.shape = Shape::kCylinder, .size = {radius, half_length, 0}, .pos = pos};
}

Vec3 polar(double radius, double angle) {
  return {radius * real::cos(angle), radius * real::sin(angle), 0};
}

Primitives cross(double scale) {
  const double arm = 1.5 * scale;
  const double thick = thick_half(scale);
  return {box({arm, thick, thick}), box({thick, arm, thick})};
}

// A ring of posts on the middles of an octagon's edges; a post is as long as its edge.
Primitives torus(double scale) {
  constexpr int kSegments = 8;
  const double tube = scale / 2;
  const double edge_half = kPi / kSegments;
  Primitives result;
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2 * kPi * (i + 0.5) / kSegments;
    result.push_back(
        disc(tube, scale * real::sin(edge_half), polar(scale * real::cos(edge_half), angle)));
  }
  return result;
}

Primitives star(double scale) {
  constexpr int kPoints = 5;
  const double arm_half = 1.5 * scale / 2;
  const double thick = thick_half(scale);
  Primitives result;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * kPi * i / kPoints;
    Primitive arm = box({arm_half, thick, thick}, polar(arm_half, angle));
    arm.quat = {real::cos(angle / 2), 0, 0, real::sin(angle / 2)};
    result.push_back(arm);
  }
  return result;
}

// Three steps.
Primitives pyramide(double scale) {
  const double step_half = scale / 4;
  Primitives result;
  double z = 0;
  for (const double factor : {1.0, 0.7, 0.4}) {
    const double half = factor * scale;
    result.push_back(box({half, half, step_half}, {0, 0, z}));
    z += 2 * step_half;
  }
  return result;
}

// Lies flat; the origin is the free end of the stem.
Primitives t_shape(double scale) {
  const double height = 2 * scale;
  const double thick = thick_half(scale);
  return {box({scale, thick, thick}, {0, height - thick, 0}),
          box({thick, height / 2, thick}, {0, height / 2, 0})};
}

// An arc of discs, one segment longer than half a circle.
Primitives arc(double scale, double radius, double shift) {
  constexpr int kSegments = 12;
  const double disc_radius = scale / 2;
  const double edge_half = kPi / (2 * (kSegments - 1));
  Primitives result;
  for (int i = 0; i < kSegments; ++i) {
    Vec3 pos = polar(radius * real::cos(edge_half), (2 * i + 1) * edge_half);
    pos[0] += shift;
    result.push_back(disc(disc_radius, radius * real::sin(edge_half), pos));
  }
  return result;
}

// Two arcs. The inner one is thinner and invisible; it fills the hole of the outer one. Only three
// of its discs reach beyond the outer ones, so the others need not collide.
Primitives crescent(double scale) {
  const double thickness = scale / 2;
  Primitives inner = arc(scale, scale - thickness, 0.7 * thickness);
  for (Primitive& segment : inner) segment.visible = segment.collides = false;
  for (const std::size_t filler : {0U, 6U, 11U}) inner[filler].collides = true;

  Primitives result = arc(scale, scale, 0);
  result.insert(result.end(), inner.begin(), inner.end());
  return result;
}

Primitives primitives_of(ObjectShape shape, double scale) {
  switch (shape) {
    case ObjectShape::kCube:
      return {box({scale, scale, scale})};
    case ObjectShape::kSphere:
      return {{.shape = Shape::kSphere, .size = {scale, 0, 0}}};
    case ObjectShape::kCylinder:
      return {disc(scale, scale)};
    case ObjectShape::kCross:
      return cross(scale);
    case ObjectShape::kTorus:
      return torus(scale);
    case ObjectShape::kStar:
      return star(scale);
    case ObjectShape::kPyramide:
      return pyramide(scale);
    case ObjectShape::kTShape:
      return t_shape(scale);
    case ObjectShape::kCrescent:
      return crescent(scale);
  }
  return {};
}

}  // namespace

std::string_view shape_name(ObjectShape shape) {
  return kObjectShapeNames[static_cast<std::size_t>(shape)];
}

double resting_height(ObjectShape shape) {
  Prop prop;
  prop.primitives = primitives_of(shape, kShapeScale);
  return standing_height(prop);
}

Prop shape_prop(const std::string& name, ObjectShape shape, const Rgba& rgba, double scale) {
  if (shape == ObjectShape::kCube) return cube(name, scale, rgba);
  Prop prop;
  prop.name = name;
  prop.primitives = primitives_of(shape, scale);
  for (Primitive& primitive : prop.primitives) primitive.rgba = rgba;
  prop.kind = ObjectKind::kObject;
  prop.object_shape = static_cast<int>(shape);
  set_solid_inertia(prop);
  prop.pos = {0, 0, standing_height(prop)};
  return prop;
}

}  // namespace engram::mjcf
