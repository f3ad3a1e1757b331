#include "mjcf/ball.h"

#include <numbers>

namespace engram::mjcf {

Prop ball(const std::string& name, double radius, const Rgba& rgba) {
  constexpr double kAngularDamping = 0.05;  // 1/s
  Prop prop;
  prop.name = name;
  prop.geoms.push_back({.type = GeomType::kSphere, .size = {radius, 0, 0}, .rgba = rgba});
  prop.kind = ObjectKind::kBall;
  prop.object_shape = static_cast<int>(ObjectShape::kSphere);
  prop.mass = 4.0 / 3.0 * std::numbers::pi * radius * radius * radius * kDensity;
  const double moment = 0.4 * prop.mass * radius * radius;
  prop.inertia = {moment, moment, moment, 0, 0, 0};
  // A joint has one damping for all six velocities. This one slows the ball's travel by 1e-5 per
  // second, which does not matter.
  prop.damping = kAngularDamping * moment;
  prop.pos = {0, 0, radius};
  return prop;
}

}  // namespace engram::mjcf
