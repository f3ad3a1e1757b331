#include "mjcf/disc.h"

namespace engram::mjcf {

Prop disc(const std::string& name, double radius, double half_height, const Rgba& rgba) {
  // Rotated back from the body's orientation, so that both shapes lie flat.
  constexpr Quat kFlat{kDiscQuat[0], -kDiscQuat[1], -kDiscQuat[2], -kDiscQuat[3]};
  Prop disc;
  disc.name = name;
  disc.body_type = BodyType::kKinematic;
  disc.geoms = {
      {.type = GeomType::kCylinder,
       .size = {radius, half_height, 0},
       .quat = kFlat,
       .rgba = rgba,
       .collides = false},
      {.type = GeomType::kBox,
       .size = {radius, radius, half_height},
       .quat = kFlat,
       .visible = false},
  };
  disc.kind = ObjectKind::kPlace;
  disc.pos = {0, 0, half_height};
  disc.quat = kDiscQuat;
  return disc;
}

}  // namespace engram::mjcf
