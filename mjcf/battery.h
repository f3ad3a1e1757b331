// Batteries, the tray in which they stand and the socket that tests them. See
// docs/tasks/batteries_checker.md.
#pragma once

#include <string>
#include <vector>

#include "mjcf/prop.h"

namespace engram::mjcf {

// Orientation of an upright battery: its axis is the x axis of its body.
inline constexpr Quat kBatteryQuat{0.7071067811865476, 0, 0.7071067811865476, 0};

// Orientation of tray and socket: a quarter turn, so that their x axis is the world's y.
inline constexpr Quat kQuarterTurn{0.7071067811865476, 0, 0, 0.7071067811865476};

// Named as the class constants; m.
struct BatteryShape {
  double BATTERY_RADIUS = 0.010;
  double BATTERY_HALF_HEIGHT = 0.030;
  double BATTERY_FRICTION = 2.0;
  Rgba BATTERY_COLOR{70 / 255.0, 190 / 255.0, 90 / 255.0, 1};
};

struct TrayShape {
  Vec3 half_size{0.132, 0.076, 0.015};
  double slot_radius = 0.012;
  double slot_half_height = 0.0015;
  Rgba TRAY_COLOR{72 / 255.0, 86 / 255.0, 108 / 255.0, 1};
  Rgba SLOT_VISUAL_COLOR{42 / 255.0, 48 / 255.0, 62 / 255.0, 1};
};

struct SocketShape {
  Vec3 SOCKET_HALF_SIZE{0.048, 0.040, 0.015};
  double SOCKET_SLOT_RADIUS = 0.016;
  double slot_half_height = 0.0015;
  Rgba SOCKET_COLOR{88 / 255.0, 92 / 255.0, 98 / 255.0, 1};
  Rgba SOCKET_SLOT_COLOR{32 / 255.0, 32 / 255.0, 36 / 255.0, 1};

  // Half width of the square hole.
  double hole_half_width() const;
  // Height of the hole's floor above the socket's underside.
  double floor_height() const;
};

// A battery; the body's x axis is its axis.
Prop battery(const std::string& name, const BatteryShape& shape = {});

// Visual only: the batteries stand on the table. `slots`: centres of the slots, in the tray's
// frame.
Prop battery_tray(const std::string& name, const std::vector<std::array<double, 2>>& slots,
                  const TrayShape& shape = {});

// A block with a hole that takes a battery, but no fingers. Rendered solid.
Prop battery_socket(const std::string& name, const SocketShape& shape = {});

}  // namespace engram::mjcf
