#include "tasks/rotate/peg_turner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/math/real_functions.h"
#include "tasks/common/poses.h"
#include "tasks/common/tool_servo.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {
namespace {

using Vec2 = Eigen::Vector2d;
using Vector = Eigen::Vector3d;

constexpr int kPegProp = 0;
constexpr double kPi = std::numbers::pi;
constexpr double kUsualThreshold = 0.1;  // rad

// The peg as it lies: centre, and unit vectors along and across it.
struct Peg {
  Vec2 center;
  double yaw;
  Vec2 along;
  Vec2 across;
};

Peg measure_peg(const State& state, int env) {
  const double* pos = state.prop_pos_of(env, kPegProp);
  const double yaw = peg_angle(state.prop_quat_of(env, kPegProp));
  return {
      {pos[0], pos[1]}, yaw, {real::cos(yaw), real::sin(yaw)}, {-real::sin(yaw), real::cos(yaw)}};
}

// --- pushing ---

constexpr double kApproachGap = 0.025;   // m beside the peg
constexpr double kStopWithin = 0.035;    // rad, where the threshold is the usual one
constexpr double kLeastAdvance = 0.008;  // m: less would not overcome the peg's friction
constexpr double kPushAdvance = 0.038;   // m: at most, by which a step's goal is ahead

// What follows from the size of the peg, m.
struct Push {
  explicit Push(const PegSize& size)
      : half_width(size.half_width),
        lever(0.10 * (size.half_length / kUsual.half_length)),
        height(2 * size.half_width - 0.008),
        low(2 * size.half_width + 0.008),
        travel_height(2 * size.half_width + 0.035),
        inner(0.04 * (lever / 0.10)),
        outer(size.half_length + 0.015),
        drift(0.45 * (size.half_length / kUsual.half_length)) {}

  static constexpr PegSize kUsual = {};

  double half_width;
  double lever;          // from the centre
  double height;         // the tips alone touch; what is above them is wider
  double low;            // beside the peg
  double travel_height;  // the fingertips clear the peg
  double inner;          // where along the peg a push is one
  double outer;
  double drift;  // per rad: how far a push carries the centre along
};

// Half the size of the closed fingertips along a direction.
double finger_extent(const Vec2& direction) {
  return 0.00875 * std::abs(direction.x()) + 0.0152 * std::abs(direction.y());
}

// Where the fingers stand against the peg's side to push the end `end` (+1 or -1), when the peg is
// to turn by the sign `turn`.
Vec2 contact_point(const Peg& peg, const Push& sizes, int end, double turn, double gap) {
  const Vec2 push = end * turn * peg.across;
  return peg.center + end * sizes.lever * peg.along -
         (sizes.half_width + finger_extent(push) + gap) * push;
}

Vec2 turned_by(double angle, const Vec2& v) {
  const double sine = real::sin(angle);
  const double cosine = real::cos(angle);
  return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y()};
}

// The end that is easier to push: near the base, then and after the turn, and near the hand.
int easier_end(const Peg& peg, const Push& sizes, double turn, const Vector& tcp) {
  const double sign = turn < 0 ? -1 : 1;
  int best = 1;
  double least = std::numeric_limits<double>::max();
  for (const int end : {1, -1}) {
    Peg turned = peg;
    turned.along = turned_by(turn, peg.along);
    turned.across = turned_by(turn, peg.across);
    turned.center += end * sizes.drift * turn * turned_by(turn / 2, peg.across);
    double cost = (contact_point(peg, sizes, end, sign, kApproachGap) - tcp.head<2>()).norm();
    for (const Peg& pose : {peg, turned}) {
      const Vec2 point = contact_point(pose, sizes, end, sign, 0);
      const double reach = (point - Vec2(kRobotBaseX, 0)).norm();
      cost += 10 * std::max(0.0, reach - 0.74) + 10 * std::max(0.0, 0.36 - reach);
    }
    if (cost < least) {
      least = cost;
      best = end;
    }
  }
  return best;
}

}  // namespace

void push_peg(const State& state, int env, const PegGoal& goal, float* action) {
  const Push sizes(goal.size);
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double sign = goal.turn < 0 ? -1 : 1;
  if (std::abs(goal.turn) < kStopWithin * (goal.threshold / kUsualThreshold)) {
    hold_tool(kGripperClosed, action);
    return;
  }
  // The hand in the peg's frame.
  const Vec2 offset = tcp.head<2>() - peg.center;
  const double along = offset.dot(peg.along);
  const double across = offset.dot(peg.across);
  const bool low = tcp.z() < sizes.low;
  const int end = along < 0 ? -1 : 1;
  const double side = -end * sign * across;  // distance from the axis, on the pushing side
  const bool pushing = low && side > sizes.half_width && side < 0.12 &&
                       std::abs(along) > sizes.inner && std::abs(along) < sizes.outer;
  if (pushing) {
    const Vec2 push = end * sign * peg.across;
    const double gap = std::max(0.0, side - sizes.half_width - finger_extent(push));
    const double advance =
        std::clamp(gap + 0.5 * sizes.lever * std::abs(goal.turn), kLeastAdvance, kPushAdvance);
    const Vec2 command =
        advance * push / kStepResponse * 0.6 + 0.8 * (end * sizes.lever - along) * peg.along;
    move_tool(state, env, {command.x(), command.y(), 1.6 * (sizes.height - tcp.z())},
              lean_outwards(kToolDown, tcp), kGripperClosed, action);
    return;
  }
  const int chosen = easier_end(peg, sizes, goal.turn, tcp);
  const Vec2 start = contact_point(peg, sizes, chosen, sign, kApproachGap);
  const bool overhead = (start - tcp.head<2>()).norm() < 0.02;
  const Vector way(start.x(), start.y(), overhead ? sizes.height : sizes.travel_height);
  servo_tool(state, env, way, lean_outwards(kToolDown, way), kGripperClosed, action);
}

// --- grasping and twisting ---

namespace {

constexpr double kGraspGap = 0.002;  // m above the peg's axis
constexpr double kHoverGap = 0.025;  // m above the peg: the open fingertips clear it
constexpr double kLowGap = 0.005;    // m above the peg: the fingertips are beside it
// Rad, where the open fingers leave the usual room on both sides of the peg.
constexpr double kMostMisalignment = 0.3;  // the closing fingers turn the peg by as much
constexpr double kMayComeDown = 0.55;
constexpr double kFingerOpening = 0.04;  // m to either side
constexpr double kUsualRoom = 0.015;     // m
constexpr double kLeastYaw = -2.0;       // rad: what the wrist can do
constexpr double kMostYaw = 3.5;
constexpr double kTurnedWithin = 0.03;  // rad, where the threshold is the usual one

// The hand's yaw for a grasp: across the peg, turned ahead in the direction of the target.
double grasp_yaw(const Peg& peg, double turn, double room) {
  const double most = kMostMisalignment * room;
  const double ahead = std::clamp(turn, -most, most);
  double best = 0;
  double least = std::numeric_limits<double>::max();
  for (int k = -3; k <= 3; ++k) {
    const double yaw = peg.yaw + ahead + k * kPi;
    const double last = yaw + turn - ahead;
    if (std::min(yaw, last) < kLeastYaw || std::max(yaw, last) > kMostYaw) continue;
    const double cost = std::abs(yaw);
    if (cost < least) {
      least = cost;
      best = yaw;
    }
  }
  return best;
}

}  // namespace

void twist_peg(const State& state, int env, const PegGoal& goal, float* action) {
  const double grasp_height = goal.size.half_width + kGraspGap;
  const double peg_height = 2 * goal.size.half_width;
  const double room = std::min(1.0, (kFingerOpening - goal.size.half_width) / kUsualRoom);
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double yaw = tool_yaw(state, env);
  if (is_grasping(state, env, kPegProp)) {
    const Vec2 shift = Vec2(goal.x, goal.y) - peg.center;
    const double turn =
        std::abs(goal.turn) < kTurnedWithin * (goal.threshold / kUsualThreshold) ? 0.0 : goal.turn;
    if (turn == 0 || goal.wait) {
      hold_tool(kGripperSqueezing, action);
    } else {
      move_tool(state, env, {shift.x(), shift.y(), 0}, tool_down(yaw + turn), kGripperSqueezing,
                action);
    }
    return;
  }
  const Vec2 offset = peg.center - tcp.head<2>();
  // On the way down and closing, the hand keeps its yaw.
  const double misaligned = std::abs(wrap_angle(2 * (yaw - peg.yaw)) / 2);
  const bool low = tcp.z() < peg_height + kLowGap && offset.norm() < 0.03;
  const double wanted = low ? yaw : grasp_yaw(peg, goal.turn, room);
  const bool ready = low || (std::abs(wrap_angle(wanted - yaw)) < 0.06 && offset.norm() < 0.008 &&
                             misaligned < kMayComeDown * room);
  const double height = ready ? grasp_height : peg_height + kHoverGap;
  const bool close = low && tcp.z() < grasp_height + 0.01;
  servo_tool(state, env, {peg.center.x(), peg.center.y(), height}, tool_down(wanted),
             close ? kGripperSqueezing : kGripperOpen, action);
}

}  // namespace engram::tasks
