#include "mjcf/shapes.h"

#include <array>
#include <numbers>
#include <vector>

#include "core/base/real_functions.h"
#include "mjcf/footing.h"
#include "mjcf/inertia.h"

namespace engram::mjcf {
namespace {

// All sizes follow from one length.
constexpr double kScale = 0.02;           // m, SHAPE_SCALE
constexpr double kThick = 0.75 * kScale;  // width of a cross, thickness of star and t_shape
constexpr double kThickHalf = 0.5 * kThick;
constexpr double kPi = std::numbers::pi;

using Primitives = std::vector<Primitive>;

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

Primitives cross() {
  constexpr double kArm = 1.5 * kScale;
  return {box({kArm, kThickHalf, kThickHalf}), box({kThickHalf, kArm, kThickHalf})};
}

// A ring of posts on the middles of an octagon's edges; a post is as long as its edge.
Primitives torus() {
  constexpr int kSegments = 8;
  constexpr double kTube = kScale / 2;
  const double edge_half = kPi / kSegments;
  Primitives result;
  for (int i = 0; i < kSegments; ++i) {
    const double angle = 2 * kPi * (i + 0.5) / kSegments;
    result.push_back(
        disc(kTube, kScale * real::sin(edge_half), polar(kScale * real::cos(edge_half), angle)));
  }
  return result;
}

Primitives star() {
  constexpr int kPoints = 5;
  constexpr double kArmHalf = 1.5 * kScale / 2;
  Primitives result;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * kPi * i / kPoints;
    Primitive arm = box({kArmHalf, kThickHalf, kThickHalf}, polar(kArmHalf, angle));
    arm.quat = {real::cos(angle / 2), 0, 0, real::sin(angle / 2)};
    result.push_back(arm);
  }
  return result;
}

// Three steps.
Primitives pyramide() {
  constexpr double kStepHalf = kScale / 4;
  Primitives result;
  double z = 0;
  for (const double factor : {1.0, 0.7, 0.4}) {
    const double half = factor * kScale;
    result.push_back(box({half, half, kStepHalf}, {0, 0, z}));
    z += 2 * kStepHalf;
  }
  return result;
}

// Lies flat; the origin is the free end of the stem.
Primitives t_shape() {
  constexpr double kHeight = 2 * kScale;
  return {box({kScale, kThickHalf, kThickHalf}, {0, kHeight - kThickHalf, 0}),
          box({kThickHalf, kHeight / 2, kThickHalf}, {0, kHeight / 2, 0})};
}

// An arc of discs, one segment longer than half a circle.
Primitives arc(double radius, double shift) {
  constexpr int kSegments = 12;
  constexpr double kDiscRadius = kScale / 2;
  const double edge_half = kPi / (2 * (kSegments - 1));
  Primitives result;
  for (int i = 0; i < kSegments; ++i) {
    Vec3 pos = polar(radius * real::cos(edge_half), (2 * i + 1) * edge_half);
    pos[0] += shift;
    result.push_back(disc(kDiscRadius, radius * real::sin(edge_half), pos));
  }
  return result;
}

// Two arcs. The inner one is thinner and invisible; it fills the hole of the outer one. Only three
// of its discs reach beyond the outer ones, so the others need not collide.
Primitives crescent() {
  constexpr double kThickness = kScale / 2;
  Primitives inner = arc(kScale - kThickness, 0.7 * kThickness);
  for (Primitive& segment : inner) segment.visible = segment.collides = false;
  for (const std::size_t filler : {0U, 6U, 11U}) inner[filler].collides = true;

  Primitives result = arc(kScale, 0);
  result.insert(result.end(), inner.begin(), inner.end());
  return result;
}

Primitives primitives_of(ObjectShape shape) {
  switch (shape) {
    case ObjectShape::kCube:
      return {box({kScale, kScale, kScale})};
    case ObjectShape::kSphere:
      return {{.shape = Shape::kSphere, .size = {kScale, 0, 0}}};
    case ObjectShape::kCylinder:
      return {disc(kScale, kScale)};
    case ObjectShape::kCross:
      return cross();
    case ObjectShape::kTorus:
      return torus();
    case ObjectShape::kStar:
      return star();
    case ObjectShape::kPyramide:
      return pyramide();
    case ObjectShape::kTShape:
      return t_shape();
    case ObjectShape::kCrescent:
      return crescent();
  }
  return {};
}

}  // namespace

std::string_view shape_name(ObjectShape shape) {
  constexpr std::array<std::string_view, kObjectShapeCount> kNames = {
      "cube", "sphere", "cylinder", "cross", "torus", "star", "pyramide", "t_shape", "crescent"};
  return kNames[static_cast<std::size_t>(shape)];
}

double resting_height(ObjectShape shape) {
  Prop prop;
  prop.primitives = primitives_of(shape);
  return standing_height(prop);
}

Prop shape_prop(const std::string& name, ObjectShape shape, const Rgba& rgba) {
  if (shape == ObjectShape::kCube) return cube(name, kScale, rgba);
  Prop prop;
  prop.name = name;
  prop.primitives = primitives_of(shape);
  for (Primitive& primitive : prop.primitives) primitive.rgba = rgba;
  set_solid_inertia(prop);
  prop.pos = {0, 0, standing_height(prop)};
  return prop;
}

}  // namespace engram::mjcf
