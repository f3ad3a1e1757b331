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
  prop.geoms.push_back(
      {.type = GeomType::kBox, .size = {half_size, half_size, half_size}, .rgba = rgba});
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
  prop.body_type = BodyType::kKinematic;
  prop.geoms.push_back(
      {.type = GeomType::kSphere, .size = {radius, 0, 0}, .rgba = rgba, .collides = false});
  prop.kind = ObjectKind::kBall;
  prop.object_shape = static_cast<int>(ObjectShape::kSphere);
  prop.pos = {0, 0, radius};
  return prop;
}

bool same_physics(const Prop& a, const Prop& b) {
  const auto same_geom = [](const Geom& p, const Geom& q) {
    return p.type == q.type && p.size == q.size && p.pos == q.pos && p.quat == q.quat &&
           p.collides == q.collides;
  };
  return a.body_type == b.body_type && a.pushes_props == b.pushes_props && a.mass == b.mass &&
         a.center_of_mass == b.center_of_mass && a.inertia == b.inertia &&
         a.friction == b.friction && a.damping == b.damping &&
         std::equal(a.geoms.begin(), a.geoms.end(), b.geoms.begin(), b.geoms.end(), same_geom);
}

}  // namespace engram::mjcf
