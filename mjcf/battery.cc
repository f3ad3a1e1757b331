#include "mjcf/battery.h"

#include <algorithm>
#include <numbers>

namespace engram::mjcf {
namespace {

Geom disc_on_top(const Vec3& half_size, double radius, double half_height, const Rgba& rgba) {
  return {.type = GeomType::kCylinder,
          .size = {radius, half_height, 0},
          .pos = {0, 0, half_size[2] + half_height},
          .rgba = rgba,
          .collides = false};
}

Geom hidden_box(const Vec3& half_size, const Vec3& pos) {
  return {.type = GeomType::kBox, .size = half_size, .pos = pos, .visible = false};
}

}  // namespace

double SocketShape::hole_half_width() const {
  const double narrower = std::min(SOCKET_HALF_SIZE[0], SOCKET_HALF_SIZE[1]);
  return std::min(1.15 * SOCKET_SLOT_RADIUS, narrower - 0.004);
}

double SocketShape::floor_height() const { return 2 * std::max(0.004, 0.35 * SOCKET_HALF_SIZE[2]); }

Prop battery(const std::string& name, const BatteryShape& shape) {
  const double radius = shape.BATTERY_RADIUS;
  const double half = shape.BATTERY_HALF_HEIGHT;
  const Quat upright = {kBatteryQuat[0], -kBatteryQuat[1], -kBatteryQuat[2], -kBatteryQuat[3]};

  Prop prop;
  prop.name = name;
  prop.geoms.push_back({.type = GeomType::kCylinder,
                        .size = {radius, half, 0},
                        .quat = upright,
                        .rgba = shape.BATTERY_COLOR});

  const double height = 2 * half;
  prop.mass = std::numbers::pi * radius * radius * height * kDensity;
  const double across = prop.mass * (3 * radius * radius + height * height) / 12;
  prop.inertia = {prop.mass * radius * radius / 2, across, across, 0, 0, 0};
  prop.friction = shape.BATTERY_FRICTION;
  prop.kind = ObjectKind::kBattery;
  prop.pos = {0, 0, half};
  prop.quat = kBatteryQuat;
  return prop;
}

Prop battery_tray(const std::string& name, const std::vector<std::array<double, 2>>& slots,
                  const TrayShape& shape) {
  Prop tray;
  tray.name = name;
  tray.body_type = BodyType::kKinematic;
  tray.geoms.push_back({.type = GeomType::kBox,
                        .size = shape.half_size,
                        .rgba = shape.TRAY_COLOR,
                        .collides = false});
  for (const auto& [x, y] : slots) {
    Geom disc = disc_on_top(shape.half_size, shape.slot_radius, shape.slot_half_height,
                            shape.SLOT_VISUAL_COLOR);
    disc.pos[0] = x;
    disc.pos[1] = y;
    tray.geoms.push_back(disc);
  }
  tray.kind = ObjectKind::kRack;
  tray.pos = {0, 0, shape.half_size[2]};
  tray.quat = kQuarterTurn;
  return tray;
}

Prop battery_socket(const std::string& name, const SocketShape& shape) {
  const Vec3& outer = shape.SOCKET_HALF_SIZE;
  const double hole = shape.hole_half_width();
  const double floor = shape.floor_height() / 2;
  const double wall_x = (outer[0] - hole) / 2;  // half thickness of the walls
  const double wall_y = (outer[1] - hole) / 2;

  Prop socket;
  socket.name = name;
  socket.body_type = BodyType::kKinematic;
  socket.geoms = {
      {.type = GeomType::kBox, .size = outer, .rgba = shape.SOCKET_COLOR, .collides = false},
      disc_on_top(outer, shape.SOCKET_SLOT_RADIUS, shape.slot_half_height, shape.SOCKET_SLOT_COLOR),
      hidden_box({outer[0], outer[1], floor}, {0, 0, floor - outer[2]}),
      hidden_box({wall_x, outer[1], outer[2]}, {hole + wall_x, 0, 0}),
      hidden_box({wall_x, outer[1], outer[2]}, {-hole - wall_x, 0, 0}),
      hidden_box({hole, wall_y, outer[2]}, {0, hole + wall_y, 0}),
      hidden_box({hole, wall_y, outer[2]}, {0, -hole - wall_y, 0}),
  };
  socket.kind = ObjectKind::kRack;
  socket.pos = {0, 0, outer[2]};
  socket.quat = kQuarterTurn;
  return socket;
}

}  // namespace engram::mjcf
