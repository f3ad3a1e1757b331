// A press button on the table: a square base and a round cap that sinks while a tool presses on
// it. Base and cap are two props. Both collide; the task moves them, physics never does.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// Lengths have the names of the benchmark's class constants.
struct ButtonShape {
  Vec3 BUTTON_BASE_HALF_SIZE{0.065, 0.065, 0.015};
  double BUTTON_CAP_RADIUS = 0.03;
  double BUTTON_CAP_HALF_HEIGHT = 0.014;
  Rgba base_rgba{55 / 255.0, 64 / 255.0, 78 / 255.0, 1};
  Rgba cap_rgba{210 / 255.0, 80 / 255.0, 80 / 255.0, 1};

  // Heights above the table while it is not pressed, m.
  double base_height() const { return BUTTON_BASE_HALF_SIZE[2]; }                   // centre
  double cap_height() const { return 2 * base_height() + BUTTON_CAP_HALF_HEIGHT; }  // centre
  double top_height() const { return cap_height() + BUTTON_CAP_HALF_HEIGHT; }
};

// Orientation of the cap: its axis is the x axis of its body.
inline constexpr Quat kCapQuat{0.7071067811865476, 0, 0.7071067811865476, 0};

Prop button_base(const std::string& name, const ButtonShape& shape);
// travel: the most by which the cap sinks, m.
Prop button_cap(const std::string& name, const ButtonShape& shape, double travel);

}  // namespace engram::mjcf
