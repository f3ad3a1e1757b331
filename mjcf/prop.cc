#include "mjcf/prop.h"

#include <algorithm>

namespace engram::mjcf {

Prop cube(const std::string& name, double half_size, const Rgba& rgba) {
  constexpr double kDensity = 1000;  // kg/m^3
  const double edge = 2 * half_size;
  const double mass = edge * edge * edge * kDensity;
  const double moment = mass * edge * edge / 6;

  Prop prop;
  prop.name = name;
  prop.primitives.push_back(
      {.shape = Shape::kBox, .size = {half_size, half_size, half_size}, .rgba = rgba});
  prop.kind = ObjectKind::kObject;
  prop.object_shape = static_cast<int>(ObjectShape::kCube);
  prop.mass = mass;
  prop.inertia = {moment, moment, moment, 0, 0, 0};
  prop.pos = {0, 0, half_size};
  return prop;
}

Prop visual_sphere(const std::string& name, double radius, const Rgba& rgba) {
  Prop prop;
  prop.name = name;
  prop.motion = Motion::kKinematic;
  prop.primitives.push_back(
      {.shape = Shape::kSphere, .size = {radius, 0, 0}, .rgba = rgba, .collides = false});
  prop.kind = ObjectKind::kBall;
  prop.object_shape = static_cast<int>(ObjectShape::kSphere);
  prop.pos = {0, 0, radius};
  return prop;
}

bool same_physics(const Prop& a, const Prop& b) {
  const auto same_shape = [](const Primitive& p, const Primitive& q) {
    return p.shape == q.shape && p.size == q.size && p.pos == q.pos && p.quat == q.quat &&
           p.collides == q.collides;
  };
  return a.motion == b.motion && a.glides == b.glides && a.mass == b.mass &&
         a.center_of_mass == b.center_of_mass && a.inertia == b.inertia &&
         a.friction == b.friction && a.damping == b.damping &&
         std::equal(a.primitives.begin(), a.primitives.end(), b.primitives.begin(),
                    b.primitives.end(), same_shape);
}

}  // namespace engram::mjcf
