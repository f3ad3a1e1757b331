#include "mjcf/button.h"

namespace engram::mjcf {

Prop button_base(const std::string& name, const ButtonShape& shape) {
  Prop base;
  base.name = name;
  base.body_type = BodyType::kKinematic;
  base.geoms.push_back(
      {.type = GeomType::kBox, .size = shape.BUTTON_BASE_HALF_SIZE, .rgba = shape.base_rgba});
  base.pos = {0, 0, shape.base_height()};
  return base;
}

Prop button_cap(const std::string& name, const ButtonShape& shape, double travel) {
  Prop cap;
  cap.name = name;
  cap.body_type = BodyType::kKinematic;
  // Rotated back from the body's orientation, so that the cylinder stands upright.
  cap.geoms.push_back({.type = GeomType::kCylinder,
                       .size = {shape.BUTTON_CAP_RADIUS, shape.BUTTON_CAP_HALF_HEIGHT, 0},
                       .quat = {kCapQuat[0], -kCapQuat[1], -kCapQuat[2], -kCapQuat[3]},
                       .rgba = shape.cap_rgba});
  cap.kind = ObjectKind::kButton;
  cap.travel = travel;
  cap.pos = {0, 0, shape.cap_height()};
  cap.quat = kCapQuat;
  return cap;
}

}  // namespace engram::mjcf
