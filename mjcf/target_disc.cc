#include "mjcf/target_disc.h"

namespace engram::mjcf {

Prop target_disc(const std::string& name, double radius, const Rgba& rgba,
                 bool hidden_from_sensors) {
  constexpr int kRings = 5;
  constexpr double kHeight = 0.001;  // m: of the origin
  constexpr double kStep =
      0.0004;  // m: each disc is that much higher, so that images do not flicker
  Prop prop;
  prop.name = name;
  prop.body_type = BodyType::kKinematic;
  for (int ring = 0; ring < kRings; ++ring) {
    const double top = kHeight + kStep * ring;
    prop.geoms.push_back({.type = GeomType::kCylinder,
                          .size = {radius * (kRings - ring) / kRings, top / 2, 0},
                          .pos = {0, 0, top / 2 - kHeight},
                          .rgba = ring % 2 == 0 ? rgba : Rgba{1, 1, 1, 1},
                          .collides = false,
                          .hidden_from_sensors = hidden_from_sensors});
  }
  prop.kind = ObjectKind::kPlace;
  prop.pos = {0, 0, kHeight};
  return prop;
}

}  // namespace engram::mjcf
