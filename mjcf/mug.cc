#include "mjcf/mug.h"

#include <numbers>

#include "core/math/real_functions.h"

namespace engram::mjcf {
namespace {

// Everything here is in the frame of the handle: x along its radius, y across it, z from foot to
// rim, about the mug's origin. Metres and kilograms, of a mug of kMugScale.

constexpr double kMass = 0.30;
constexpr Vec3 kCenterOfMass = {-0.0041, -0.0057, -0.0172};
constexpr std::array<double, 6> kInertia = {4.693e-4, 4.757e-4, 6.40e-4, -7.9e-6, 0, 0};

constexpr double kAxisX = -0.0066;
constexpr double kAxisY = -0.0047;
constexpr double kRim = kMugRestingHeight;
constexpr double kRadius = 0.0533;
constexpr double kInnerRadius = 0.0514;
constexpr double kFootThickness = 0.002;
constexpr double kLipRadius = 0.0607;
constexpr double kLipHalfHeight = 0.0033;
constexpr double kAcross = kAxisY - 0.0043;  // the handle's middle
constexpr double kHandleHalfWidth = 0.0087;

// The visual walls are rings of flat staves. They overlap a little, so that no gaps show.
constexpr int kStaves = 16;
constexpr double kOverlap = 0.0002;

// The scan's median glaze. Under our lights it is as bright as in images of the original.
constexpr Rgba kGlaze = {0.199, 0.0075, 0.0098, 1};
constexpr Rgba kPale = {0.70, 0.58, 0.52, 1};

enum class Use { kCollision, kVisual };

void add(Prop& prop, Use use, GeomType type, const Vec3& size, const Vec3& pos, const Quat& quat) {
  prop.geoms.push_back({.type = type,
                        .size = size,
                        .pos = pos,
                        .quat = quat,
                        .rgba = kGlaze,
                        .collides = use == Use::kCollision,
                        .visible = use == Use::kVisual});
}

constexpr Quat kStraight = {1, 0, 0, 0};

Quat rotation_z(double angle) { return {real::cos(angle / 2), 0, 0, real::sin(angle / 2)}; }
Quat rotation_y(double angle) { return {real::cos(angle / 2), 0, real::sin(angle / 2), 0}; }

void add_collision(Prop& prop) {
  constexpr double kGap = 0.0003;  // m above the table: only the rim touches it
  const double half = kRim - kGap / 2;
  add(prop, Use::kCollision, GeomType::kCylinder, {kRadius, half, 0}, {kAxisX, kAxisY, -kGap / 2},
      kStraight);
  add(prop, Use::kCollision, GeomType::kCylinder, {kLipRadius, kLipHalfHeight, 0},
      {kAxisX, kAxisY, kRim - kLipHalfHeight}, kStraight);
  add(prop, Use::kCollision, GeomType::kBox, {0.0058, kHandleHalfWidth, 0.0280},
      {kAxisX + 0.0857, kAcross, 0}, kStraight);
  for (const double side : {-1.0, 1.0}) {
    add(prop, Use::kCollision, GeomType::kBox, {0.0145, kHandleHalfWidth, 0.0050},
        {kAxisX + 0.0665, kAcross, side * 0.031}, kStraight);
  }
}

// A ring of staves between two radii, low <= z <= high.
void add_ring(Prop& prop, double inner, double outer, double low, double high) {
  const double half_width = outer * real::tan(std::numbers::pi / kStaves) + kOverlap;
  const double middle = (inner + outer) / 2;
  for (int i = 0; i < kStaves; ++i) {
    const double angle = 2 * std::numbers::pi * i / kStaves;
    add(prop, Use::kVisual, GeomType::kBox, {(outer - inner) / 2, half_width, (high - low) / 2},
        {kAxisX + middle * real::cos(angle), kAxisY + middle * real::sin(angle), (low + high) / 2},
        rotation_z(angle));
  }
}

// The handle's loop: two arms, a bar and a strut across each corner, as wide as the handle's
// colliding box.
void add_handle(Prop& prop) {
  constexpr double kThickness = 0.0048;  // half
  const auto strap = [&prop](double from_x, double from_z, double to_x, double to_z) {
    const double length = real::hypot(to_x - from_x, to_z - from_z);
    add(prop, Use::kVisual, GeomType::kBox, {length / 2 + 0.0015, kHandleHalfWidth, kThickness},
        {kAxisX + (from_x + to_x) / 2, kAcross, (from_z + to_z) / 2},
        rotation_y(-real::atan2(to_z - from_z, to_x - from_x)));
  };
  for (const double side : {-1.0, 1.0}) {
    strap(0.0535, side * 0.0312, 0.0725, side * 0.0312);
    strap(0.0725, side * 0.0312, 0.0866, side * 0.0175);
  }
  strap(0.0866, -0.0175, 0.0866, 0.0175);
}

void add_visuals(Prop& prop) {
  add(prop, Use::kVisual, GeomType::kCylinder, {kRadius, kFootThickness / 2, 0},
      {kAxisX, kAxisY, kFootThickness / 2 - kRim}, kStraight);
  add_ring(prop, kInnerRadius, kRadius, -kRim, kRim - kLipHalfHeight);
  add_ring(prop, kInnerRadius, kLipRadius, kRim - 2 * kLipHalfHeight, kRim);
  add_handle(prop);
  // The pale spot in the middle of the foot.
  add(prop, Use::kVisual, GeomType::kCylinder, {0.005, 0.0002, 0}, {kAxisX, kAxisY, -kRim},
      kStraight);
  prop.geoms.back().rgba = kPale;
}

// --- rotation of the whole mug about +z ---

Vec3 rotated(const Vec3& v, double c, double s) {
  return {c * v[0] - s * v[1], s * v[0] + c * v[1], v[2]};
}

// A rotation about +z, then q.
Quat rotated(const Quat& q, double angle) {
  const Quat z = rotation_z(angle);
  return {z[0] * q[0] - z[3] * q[3], z[0] * q[1] - z[3] * q[2], z[0] * q[2] + z[3] * q[1],
          z[0] * q[3] + z[3] * q[0]};
}

std::array<double, 6> rotated_inertia(double c, double s) {
  const auto [xx, yy, zz, xy, xz, yz] = kInertia;
  return {c * c * xx - 2 * c * s * xy + s * s * yy,
          s * s * xx + 2 * c * s * xy + c * c * yy,
          zz,
          c * s * (xx - yy) + (c * c - s * s) * xy,
          c * xz - s * yz,
          s * xz + c * yz};
}

// Scales everything by `ratio`.
void scale_by(Prop& prop, double ratio) {
  const auto lengths = [ratio](Vec3& v) {
    for (double& length : v) length *= ratio;
  };
  for (Geom& geom : prop.geoms) {
    lengths(geom.size);
    lengths(geom.pos);
  }
  lengths(prop.pos);
  lengths(prop.center_of_mass);
  const double volume = ratio * ratio * ratio;
  prop.mass *= volume;
  for (double& moment : prop.inertia) moment *= volume * ratio * ratio;
}

}  // namespace

Prop mug(const std::string& name, double handle_yaw, double scale) {
  Prop prop;
  prop.name = name;
  prop.kind = ObjectKind::kCup;
  prop.pos = {0, 0, kMugRestingHeight};
  add_collision(prop);
  add_visuals(prop);

  const double c = real::cos(handle_yaw);
  const double s = real::sin(handle_yaw);
  for (Geom& geom : prop.geoms) {
    geom.pos = rotated(geom.pos, c, s);
    geom.quat = rotated(geom.quat, handle_yaw);
  }
  prop.mass = kMass;
  prop.center_of_mass = rotated(kCenterOfMass, c, s);
  prop.inertia = rotated_inertia(c, s);
  scale_by(prop, scale / kMugScale);
  return prop;
}

}  // namespace engram::mjcf
