#include "mjcf/prop.h"

namespace engram::mjcf {

Prop cube(const std::string& name, double half_size, const Rgba& rgba) {
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

}  // namespace engram::mjcf
