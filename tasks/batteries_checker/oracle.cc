#include "tasks/batteries_checker/oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tasks/common/grasp_servo.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

// The fingers do not fit into the socket's hole: a battery is held so that it reaches the floor
// while they are above the rim.
constexpr double kGripHeight = 0.0015;   // m above the battery's centre
constexpr double kTableHeight = 0.05;    // m, of the TCP: where the tool is slowest
constexpr double kTravelHeight = 0.13;   // m: a battery in the hand passes over all others
constexpr double kAboveSocket = 0.0015;  // m above the floor, where a battery is let go
constexpr double kAboveTable = 0.0010;   // m
constexpr double kClearance = 0.045;     // m: of the tool above the centre of one that was left
constexpr Lean kLean = {.reach = 0.765, .per_metre = 2.5, .most = 0.1};

// The fingers close along a diagonal of the tray, on which the neighbours are furthest away.
Eigen::Quaterniond along_diagonal() { return tool_down(std::numbers::pi / 4); }

// How near to its place a battery is brought: twice as near as it has to be, where that is near.
Tolerance within(double required) {
  return {.sideways = std::min(0.003, required / 2), .height = 0.0025};
}

Grip grip_of(int prop, const Eigen::Vector3d& goal) {
  return {.prop = prop,
          .tool = lean_outwards(along_diagonal(), goal, kLean),
          .height = kGripHeight,
          .opening = BatteryOracle::kOpening,
          .travel_height = kTravelHeight};
}

// Brings the tool into the middle of a battery that it is about to close on: one that is held by
// its side slips. True, and nothing is written, if there is nothing to mend.
bool is_centred(const State& state, int env, const Grip& grip, const Eigen::Vector3d& battery,
                float* action) {
  constexpr double kAround = 0.02;          // m sideways: the tool has come for this battery
  constexpr double kLow = 0.015;            // m
  constexpr double kBeforeClosing = 0.002;  // m
  constexpr double kWhileClosing = 0.005;   // m
  constexpr double kOpen = 0.02;            // m per finger
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const Eigen::Vector3d goal = battery + Eigen::Vector3d(0, 0, grip.height);
  const double distance = (goal - tcp).head<2>().norm();
  const double* fingers = state.qpos.row(env) + kArmJoints;
  const bool open = std::min(fingers[0], fingers[1]) > kOpen;
  const bool around = distance < kAround && std::abs(goal.z() - tcp.z()) < kLow;
  if (!around || distance < (open ? kBeforeClosing : kWhileClosing)) return true;
  if (is_grasping(state, env, grip.prop)) return true;  // perhaps in the air
  const Eigen::Vector3d next = open ? goal : Eigen::Vector3d(tcp.x(), tcp.y(), goal.z());
  servo_tool(state, env, next, grip.tool, grip.opening, action);
  return false;
}

}  // namespace

void BatteryOracle::act(const State& state, int env, int stage, const BatteryChoice& choice,
                        float* action) const {
  if (stage == STAGE_INSERT && choice.battery >= 0) {
    insert(state, env, choice.battery, action);
  } else if (stage == STAGE_RETURN && choice.active >= 0) {
    if (put_back(state, env, choice.active, action)) {
      press(state, env, choice.keep_down, action);
    }
  } else if (clear_tool(state, env, action)) {
    press(state, env, choice.keep_down, action);
  }
  slow_down(state, env, kTableHeight, action);
}

void BatteryOracle::insert(const State& state, int env, int battery, float* action) const {
  const int prop = rack_.prop(battery);
  Eigen::Vector3d place = rack_.socket(env);
  place.z() = BatteryRack::kSocketRest + kAboveSocket;
  const bool held = is_held(state, env, prop);
  const Grip grip = grip_of(prop, held ? place : rack_.pos(env, battery));
  if (!held && !is_centred(state, env, grip, rack_.pos(env, battery), action)) return;
  const Tolerance tolerance = within(rack_.params().SOCKET_INSERT_XY_TOL);
  if (bring(state, env, grip, place, action, tolerance)) hold_tool(kOpening, action);
}

bool BatteryOracle::put_back(const State& state, int env, int battery, float* action) const {
  const int prop = rack_.prop(battery);
  const Eigen::Vector3d place = rack_.slot(env, battery) + Eigen::Vector3d(0, 0, kAboveTable);
  const bool held = is_held(state, env, prop);
  const Grip grip = grip_of(prop, held ? place : rack_.pos(env, battery));
  if (is_at(state, env, prop, place, within(rack_.params().SLOT_RETURN_XY_TOL))) {
    return leave(state, env, grip, kClearance, action);
  }
  if (!held && !is_centred(state, env, grip, rack_.pos(env, battery), action)) return false;
  if (take(state, env, grip, action)) carry(state, env, grip, place, action);
  return false;
}

// Leaves the battery between the fingers, if there is one; one that is held goes back to its slot.
bool BatteryOracle::clear_tool(const State& state, int env, float* action) const {
  constexpr double kBetweenFingers = 0.02;  // m
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  for (int battery = 0; battery < rack_.batteries(); ++battery) {
    const Eigen::Vector3d offset = rack_.pos(env, battery) - tcp;
    if (offset.head<2>().norm() > kBetweenFingers) continue;
    if (is_held(state, env, rack_.prop(battery))) {
      return put_back(state, env, battery, action);
    }
    const Grip grip = grip_of(rack_.prop(battery), tcp);
    if (!leave(state, env, grip, kClearance, action)) return false;
  }
  return true;
}

// On the part of the pad that is nearest to the tray.
void BatteryOracle::press(const State& state, int env, bool keep_down, float* action) const {
  constexpr double kTowardsTray = 0.045;   // m
  constexpr double kInside = 0.029;        // m from the pad's edge
  constexpr double kReleaseHeight = 0.10;  // m
  constexpr double kClear = 0.012;         // m above where the button is released, or pressed
  constexpr double kOverPad = 0.02;        // m
  const PressButtonParams& pad = button_.params();
  const Eigen::Vector3d tcp = tcp_pos(state, env);
  const Vec2 center = button_.center(env);
  const double size = std::min(pad.BUTTON_PRESS_XY_RADIUS, pad.shape.BUTTON_BASE_HALF_SIZE[0]);
  const double aside = std::clamp(size - kInside, 0.0, kTowardsTray);
  Eigen::Vector3d goal(center.x(), center.y() - aside,
                       std::max(kReleaseHeight, pad.release_height() + kClear));
  if (keep_down || button_.ready(env)) goal = {goal.x(), goal.y(), button_.pressing_height()};
  const bool over = (goal - tcp).head<2>().norm() < kOverPad;
  const double travel = std::max(kTravelHeight, pad.zone_height() + kClear);
  if (!over) goal = over_the_top(state, env, goal, travel);
  servo_tool(state, env, goal, along_diagonal(), kGripperClosed, action);
}

}  // namespace engram::tasks
