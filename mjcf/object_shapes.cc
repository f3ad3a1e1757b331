#include "mjcf/object_shapes.h"

#include <array>
#include <numbers>
#include <vector>

#include "core/math/real_functions.h"
#include "mjcf/inertia.h"
#include "mjcf/table_contact.h"

namespace engram::mjcf {
namespace {

// All sizes follow from one length, SHAPE_SCALE: `scale`, m.
constexpr double kPi = std::numbers::pi;

using Geoms = std::vector<Geom>;

// Half the width of a cross, and half the thickness of star and t_shape.
double thick_half(double scale) { return 0.5 * (0.75 * scale); }

Geom box(const Vec3& half, const Vec3& pos = {}) {
  return {.type = GeomType::kBox, .size = half, .pos = pos};
}

// An upright disc or post.
Geom disc(double radius, double half_length, const Vec3& pos = {}) {
  return {.type = GeomType::kCylinder, .size = {radius, half_length, 0}, .pos = pos};
}

Vec3 polar(double radius, double angle) {
  return {radius * real::cos(angle), radius * real::sin(angle), 0};
}

Geoms cross(double scale) {
  const double arm = 1.5 * scale;
  const double thick = thick_half(scale);
  return {box({arm, thick, thick}), box({thick, arm, thick})};
}

// A ring of posts on the middles of an octagon's edges; a post is as long as its edge.
Geoms torus(double scale) {
  constexpr int kSegments = 8;
  const double tube = scale / 2;
  const double edge_half = kPi / kSegments;
  Geoms result;
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2 * kPi * (i + 0.5) / kSegments;
    result.push_back(
        disc(tube, scale * real::sin(edge_half), polar(scale * real::cos(edge_half), angle)));
  }
  return result;
}

Geoms star(double scale) {
  constexpr int kPoints = 5;
  const double arm_half = 1.5 * scale / 2;
  const double thick = thick_half(scale);
  Geoms result;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * kPi * i / kPoints;
    Geom arm = box({arm_half, thick, thick}, polar(arm_half, angle));
    arm.quat = {real::cos(angle / 2), 0, 0, real::sin(angle / 2)};
    result.push_back(arm);
  }
  return result;
}

// Three steps.
Geoms pyramide(double scale) {
  const double step_half = scale / 4;
  Geoms result;
  double z = 0;
  for (const double factor : {1.0, 0.7, 0.4}) {
    const double half = factor * scale;
    result.push_back(box({half, half, step_half}, {0, 0, z}));
    z += 2 * step_half;
  }
  return result;
}

// Lies flat; the origin is the free end of the stem.
Geoms t_shape(double scale) {
  const double height = 2 * scale;
  const double thick = thick_half(scale);
  return {box({scale, thick, thick}, {0, height - thick, 0}),
          box({thick, height / 2, thick}, {0, height / 2, 0})};
}

// An arc of discs, one segment longer than half a circle.
Geoms arc(double scale, double radius, double shift) {
  constexpr int kSegments = 12;
  const double disc_radius = scale / 2;
  const double edge_half = kPi / (2 * (kSegments - 1));
  Geoms result;
  for (int i = 0; i < kSegments; ++i) {
    Vec3 pos = polar(radius * real::cos(edge_half), (2 * i + 1) * edge_half);
    pos[0] += shift;
    result.push_back(disc(disc_radius, radius * real::sin(edge_half), pos));
  }
  return result;
}

// Two arcs. The inner one is thinner and invisible; it fills the hole of the outer one. Only three
// of its discs reach beyond the outer ones, so the others need not collide.
Geoms crescent(double scale) {
  const double thickness = scale / 2;
  Geoms inner = arc(scale, scale - thickness, 0.7 * thickness);
  for (Geom& segment : inner) segment.visible = segment.collides = false;
  for (const std::size_t filler : {0U, 6U, 11U}) inner[filler].collides = true;

  Geoms result = arc(scale, scale, 0);
  result.insert(result.end(), inner.begin(), inner.end());
  return result;
}

Geoms geoms_of(ObjectShape shape, double scale) {
  switch (shape) {
    case ObjectShape::kCube:
      return {box({scale, scale, scale})};
    case ObjectShape::kSphere:
      return {{.type = GeomType::kSphere, .size = {scale, 0, 0}}};
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
  prop.geoms = geoms_of(shape, kShapeScale);
  return height_on_table(prop);
}

Prop shape_prop(const std::string& name, ObjectShape shape, const Rgba& rgba, double scale) {
  if (shape == ObjectShape::kCube) return cube(name, scale, rgba);
  Prop prop;
  prop.name = name;
  prop.geoms = geoms_of(shape, scale);
  for (Geom& geom : prop.geoms) geom.rgba = rgba;
  prop.kind = ObjectKind::kObject;
  prop.object_shape = static_cast<int>(shape);
  set_solid_inertia(prop);
  prop.pos = {0, 0, height_on_table(prop)};
  return prop;
}

}  // namespace engram::mjcf
