#include "tasks/batteries_checker/rack.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/math/real_functions.h"
#include "mjcf/battery.h"
#include "tasks/batteries_checker/params.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

constexpr mjcf::BatteryShape kBattery;
constexpr mjcf::SocketShape kSocket;
constexpr double kBesides = 0.021;  // m between the axes of batteries that do not touch
constexpr double kNear = 0.08;      // m between the centres of batteries that may touch

// Offset of a slot from the tray's centre, in the world's axes.
Vec2 slot_offset(int slot) {
  const int column = slot % TRAY_COLS;
  const int row = slot / TRAY_COLS;
  return {-(column - 1) * SLOT_SPACING_Y, (row - 2) * SLOT_SPACING_X};
}

}  // namespace

BatteryRack::BatteryRack(mjcf::Scene& scene, const BatteryParams& params)
    : params_(params),
      first_(static_cast<int>(scene.props.size())),
      tray_(first_ + params.ACTIVE_BATTERY_COUNT),
      socket_(tray_ + 1) {
  const Vec2 tray((kTrayX.low + kTrayX.high) / 2, (kTrayY.low + kTrayY.high) / 2);
  for (int battery = 0; battery < batteries(); ++battery) {
    scene.props.push_back(mjcf::battery("battery_" + std::to_string(battery), kBattery));
    const Vec2 at = tray + slot_offset(battery);
    scene.props.back().pos = {at.x(), at.y(), kBattery.BATTERY_HALF_HEIGHT};
  }
  std::vector<std::array<double, 2>> slots;
  for (int slot = 0; slot < NUM_BATTERIES; ++slot) {
    const Vec2 offset = slot_offset(slot);
    slots.push_back({offset.y(), -offset.x()});  // a quarter turn back
  }
  scene.props.push_back(mjcf::battery_tray("battery_tray", slots));
  scene.props.push_back(mjcf::battery_socket("battery_socket_box", kSocket));
}

void BatteryRack::bind(const Bindings& bindings) {
  engine_ = bindings;
  tray_xy_ = bindings.memory->add<double>("tray_xy", 2, "m");
}

void BatteryRack::reset(int env, const Vec2& tray) const {
  const State& state = *engine_.state;
  Eigen::Map<Vec2>(tray_xy_.row(env)) = tray;
  for (int battery = 0; battery < batteries(); ++battery) {
    state.place_prop(env, prop(battery), slot(env, battery).data(), mjcf::kBatteryQuat.data());
  }
  const double on_table[3] = {tray.x(), tray.y(), mjcf::TrayShape{}.half_size[2]};
  state.place_prop(env, tray_, on_table, mjcf::kQuarterTurn.data());
  const Vec2 center = socket(env).head<2>();
  const double block[3] = {center.x(), center.y(), kSocket.SOCKET_HALF_SIZE[2]};
  state.place_prop(env, socket_, block, mjcf::kQuarterTurn.data());
}

Eigen::Vector3d BatteryRack::slot(int env, int slot) const {
  const Vec2 at = tray(env) + slot_offset(slot);
  return {at.x(), at.y(), kBattery.BATTERY_HALF_HEIGHT};
}

Eigen::Vector3d BatteryRack::socket(int env) const {
  return {tray(env).x() + SOCKET_X_OFFSET_FROM_TRAY, tray(env).y(), kBattery.BATTERY_HALF_HEIGHT};
}

Eigen::Vector3d BatteryRack::pos(int env, int battery) const {
  return prop_pos(*engine_.state, env, prop(battery));
}

BatterySet BatteryRack::grasped(int env) const {
  BatterySet set = 0;
  for (int battery = 0; battery < batteries(); ++battery) {
    if (is_grasping(*engine_.state, env, prop(battery))) set |= battery_bit(battery);
  }
  return set;
}

BatterySet BatteryRack::in_socket(int env) const {
  BatterySet set = 0;
  for (int battery = 0; battery < batteries(); ++battery) {
    const Eigen::Vector3d offset = pos(env, battery) - socket(env);
    const bool inside = offset.head<2>().norm() <= params_.SOCKET_INSERT_XY_TOL &&
                        std::abs(offset.z()) <= params_.SOCKET_INSERT_Z_TOL;
    if (inside) set |= battery_bit(battery);
  }
  return set;
}

BatterySet BatteryRack::home(int env, double tolerance) const {
  BatterySet set = 0;
  for (int battery = 0; battery < batteries(); ++battery) {
    const Eigen::Vector3d offset = pos(env, battery) - slot(env, battery);
    const bool there = offset.head<2>().norm() <= tolerance * params_.SLOT_RETURN_XY_TOL &&
                       std::abs(offset.z()) <= tolerance * params_.SLOT_RETURN_Z_TOL;
    if (there) set |= battery_bit(battery);
  }
  return set;
}

// The fingers bound the battery along the line on which they close, if they are low and around it.
void BatteryRack::snap(int env, int battery) const {
  constexpr double kFingerReach = 0.081;  // m: highest TCP whose fingers reach a battery there
  constexpr double kFingerWidth = 0.009;  // m: half
  constexpr double kPlay = 0.0005;        // m
  const State& state = *engine_.state;
  Eigen::Vector3d place = socket(env);
  place.z() = kSocketRest;
  const double* quat = state.tcp_quat.row(env);
  const Eigen::Quaterniond tool(quat[0], quat[1], quat[2], quat[3]);
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const Vec2 opening = (tool * Eigen::Vector3d::UnitY()).head<2>().normalized();
  const Vec2 offset = (place - tcp).head<2>();
  const double across = std::abs(opening.x() * offset.y() - opening.y() * offset.x());
  const double radius = kBattery.BATTERY_RADIUS;
  if (tcp.z() < kFingerReach && across < radius + kFingerWidth) {
    const double* fingers = state.qpos.row(env) + kArmJoints;
    const double high = fingers[0] - radius - kPlay;
    const double low = radius + kPlay - fingers[1];
    const double along = offset.dot(opening);
    const double allowed = low < high ? std::clamp(along, low, high) : (low + high) / 2;
    place.head<2>() += (allowed - along) * opening;
  }
  teleport(env, battery, place, false);
}

void BatteryRack::send_home(int env, int battery) const {
  const Eigen::Vector3d home = slot(env, battery);
  Eigen::Vector3d place = home;
  bool clear = is_free(env, battery, home.head<2>());
  constexpr int kRings = 9;
  constexpr int kAngles = 24;
  for (int ring = 1; ring <= kRings && !clear; ++ring) {
    for (int step = 0; step < kAngles && !clear; ++step) {
      const double angle = 2 * std::numbers::pi * step / kAngles;
      const double radius = params_.SLOT_RETURN_XY_TOL * 0.98 * ring / kRings;
      const Vec2 beside = home.head<2>() + radius * Vec2(real::cos(angle), real::sin(angle));
      clear = is_free(env, battery, beside);
      if (clear) place.head<2>() = beside;
    }
  }
  teleport(env, battery, place, clear);
}

// Horizontal distance of a point from a battery's axis.
double BatteryRack::axis_distance(int env, int battery, const Vec2& point) const {
  const double* quat = engine_.state->prop_quat_of(env, prop(battery));
  const Eigen::Quaterniond turn(quat[0], quat[1], quat[2], quat[3]);
  const Vec2 axis = kBattery.BATTERY_HALF_HEIGHT * (turn * Eigen::Vector3d::UnitX()).head<2>();
  const Vec2 offset = point - pos(env, battery).head<2>();
  const double length = axis.squaredNorm();
  const double along = length > 0 ? std::clamp(offset.dot(axis) / length, -1.0, 1.0) : 0.0;
  return (offset - along * axis).norm();
}

// True if no other battery is in the way of one that stands there.
bool BatteryRack::is_free(int env, int battery, const Vec2& point) const {
  for (int other = 0; other < batteries(); ++other) {
    if (other != battery && axis_distance(env, other, point) < kBesides) return false;
  }
  return true;
}

// Bodies that leaned on the battery must not be left hanging in the air, and those that it is put
// against have to give way.
void BatteryRack::teleport(int env, int battery, const Eigen::Vector3d& place, bool clear) const {
  const State& state = *engine_.state;
  const Eigen::Vector3d from = pos(env, battery);
  state.place_prop(env, prop(battery), place.data(), mjcf::kBatteryQuat.data(),
                   clear ? PropStatus::kAsleep : PropStatus::kAwake);
  for (int other = 0; other < batteries(); ++other) {
    if (other == battery || (pos(env, other) - from).norm() > kNear) continue;
    state.prop_status.row(env)[prop(other)] = static_cast<std::uint8_t>(PropStatus::kAwake);
    state.prop_slow_steps.row(env)[prop(other)] = 0;
  }
}

}  // namespace engram::tasks
