#include "mjcf/lamp.h"

namespace engram::mjcf {
namespace {

constexpr Rgba kStand = {65 / 255.0, 70 / 255.0, 80 / 255.0, 1};
constexpr Rgba kMetal = {205 / 255.0, 205 / 255.0, 205 / 255.0, 1};
constexpr Rgba kWhite = {1, 1, 1, 1};

Geom part(GeomType type, const Vec3& size, double height, const Rgba& rgba) {
  return {.type = type, .size = size, .pos = {0, 0, height}, .rgba = rgba, .collides = false};
}

Prop lamp_part(const std::string& name) {
  Prop prop;
  prop.name = name;
  prop.body_type = BodyType::kKinematic;
  prop.pos = {0, 0, 0};
  return prop;
}

}  // namespace

Prop lamp_body(const std::string& name) {
  Prop prop = lamp_part(name);
  prop.geoms = {
      part(GeomType::kBox, {0.0216, 0.0216, 0.008}, 0.008, kStand),
      part(GeomType::kBox, {0.004, 0.004, 0.020}, 0.036, kMetal),
      part(GeomType::kBox, {0.0099, 0.0099, 0.0032}, 0.0592, kMetal),
  };
  return prop;
}

// Neck and globe, measured in images of the original, and a shoulder between them.
Prop lamp_bulb(const std::string& name) {
  Prop prop = lamp_part(name);
  prop.kind = ObjectKind::kLamp;
  prop.geoms = {
      part(GeomType::kCylinder, {0.017, 0.021, 0}, 0.037, kWhite),
      part(GeomType::kEllipsoid, {0.027, 0.027, 0.032}, 0.070, kWhite),
      part(GeomType::kSphere, {0.031, 0, 0}, 0.082, kWhite),
  };
  return prop;
}

}  // namespace engram::mjcf
