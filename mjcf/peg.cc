#include "mjcf/peg.h"

namespace engram::mjcf {

Prop peg(const std::string& name, double half_length, double half_width, const Rgba& negative_half,
         const Rgba& positive_half) {
  Prop prop;
  prop.name = name;
  prop.geoms.push_back(
      {.type = GeomType::kBox, .size = {half_length, half_width, half_width}, .visible = false});
  const auto add_half = [&](double x, const Rgba& rgba) {
    prop.geoms.push_back({.type = GeomType::kBox,
                          .size = {half_length / 2, half_width, half_width},
                          .pos = {x, 0, 0},
                          .rgba = rgba,
                          .collides = false});
  };
  add_half(-half_length / 2, negative_half);
  add_half(half_length / 2, positive_half);
  const double length = 2 * half_length;
  const double width = 2 * half_width;
  prop.mass = length * width * width * kDensity;
  const double across = prop.mass * (length * length + width * width) / 12;
  prop.inertia = {prop.mass * width * width / 6, across, across, 0, 0, 0};
  prop.kind = ObjectKind::kPeg;
  prop.pos = {0, 0, half_width};
  return prop;
}

}  // namespace engram::mjcf
