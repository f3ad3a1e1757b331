#include "tasks/rotate/peg_turner.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/real_functions.h"
#include "tasks/parts/poses.h"
#include "tasks/parts/tool_servo.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {
namespace {

using Vec2 = Eigen::Vector2d;
using Vector = Eigen::Vector3d;

constexpr int kPegProp = 0;
constexpr double kPi = std::numbers::pi;

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

constexpr double kPushLever = 0.10;      // m from the centre
constexpr double kPushHeight = 0.042;    // m: the tips alone touch; what is above them is wider
constexpr double kTravelHeight = 0.085;  // m: the fingertips clear the peg
constexpr double kApproachGap = 0.025;   // m beside the peg
constexpr double kStopWithin = 0.035;    // rad
constexpr double kDrift = 0.12;          // m/rad: how far a push carries the centre along
constexpr double kLeastAdvance = 0.008;  // m: less would not overcome the peg's friction
constexpr double kPushAdvance = 0.03;    // m: at most, by which a step's goal is ahead

// Half the size of the closed fingertips along a direction.
double finger_extent(const Vec2& direction) {
  return 0.00875 * std::abs(direction.x()) + 0.0152 * std::abs(direction.y());
}

// Where the fingers stand against the peg's side to push the end `end` (+1 or -1), when the peg is
// to turn by the sign `turn`.
Vec2 contact_point(const Peg& peg, int end, double turn, double gap) {
  const Vec2 push = end * turn * peg.across;
  return peg.center + end * kPushLever * peg.along -
         (PEG_HALF_WIDTH + finger_extent(push) + gap) * push;
}

Vec2 turned_by(double angle, const Vec2& v) {
  const double sine = real::sin(angle);
  const double cosine = real::cos(angle);
  return {cosine * v.x() - sine * v.y(), sine * v.x() + cosine * v.y()};
}

// The end that is easier to push: near the base, then and after the turn, and near the hand.
int easier_end(const Peg& peg, double turn, const Vector& tcp) {
  const double sign = turn < 0 ? -1 : 1;
  int best = 1;
  double least = std::numeric_limits<double>::max();
  for (const int end : {1, -1}) {
    Peg turned = peg;
    turned.along = turned_by(turn, peg.along);
    turned.across = turned_by(turn, peg.across);
    turned.center += end * kDrift * turn * turned_by(turn / 2, peg.across);
    double cost = (contact_point(peg, end, sign, kApproachGap) - tcp.head<2>()).norm();
    for (const Peg& pose : {peg, turned}) {
      const Vec2 point = contact_point(pose, end, sign, 0);
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
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double sign = goal.turn < 0 ? -1 : 1;
  if (std::abs(goal.turn) < kStopWithin) {
    hold_tool(kGripperClosed, action);
    return;
  }
  // The hand in the peg's frame.
  const Vec2 offset = tcp.head<2>() - peg.center;
  const double along = offset.dot(peg.along);
  const double across = offset.dot(peg.across);
  const bool low = tcp.z() < 0.058;
  const int end = along < 0 ? -1 : 1;
  const double side = -end * sign * across;  // distance from the axis, on the pushing side
  const bool pushing = low && side > PEG_HALF_WIDTH && side < 0.12 && std::abs(along) > 0.04 &&
                       std::abs(along) < 0.135;
  if (pushing) {
    const Vec2 push = end * sign * peg.across;
    const double gap = std::max(0.0, side - PEG_HALF_WIDTH - finger_extent(push));
    const double advance =
        std::clamp(gap + 0.5 * kPushLever * std::abs(goal.turn), kLeastAdvance, kPushAdvance);
    const Vec2 command =
        advance * push / kStepResponse * 0.6 + 0.8 * (end * kPushLever - along) * peg.along;
    move_tool(state, env, {command.x(), command.y(), 1.6 * (kPushHeight - tcp.z())},
              lean_outwards(kToolDown, tcp), kGripperClosed, action);
    return;
  }
  const int chosen = easier_end(peg, goal.turn, tcp);
  const Vec2 start = contact_point(peg, chosen, sign, kApproachGap);
  const bool overhead = (start - tcp.head<2>()).norm() < 0.02;
  const Vector way(start.x(), start.y(), overhead ? kPushHeight : kTravelHeight);
  servo_tool(state, env, way, lean_outwards(kToolDown, way), kGripperClosed, action);
}

// --- grasping and twisting ---

namespace {

constexpr double kGraspHeight = 0.027;     // m
constexpr double kHoverHeight = 0.075;     // m: the open fingertips clear the peg
constexpr double kMostMisalignment = 0.3;  // rad: the closing fingers turn the peg by as much
constexpr double kLeastYaw = -2.0;         // rad: what the wrist can do
constexpr double kMostYaw = 3.5;
constexpr double kTurnedWithin = 0.03;  // rad

// The hand's yaw for a grasp: across the peg, turned ahead in the direction of the target.
double grasp_yaw(const Peg& peg, double turn) {
  const double ahead = std::clamp(turn, -kMostMisalignment, kMostMisalignment);
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
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double yaw = tool_yaw(state, env);
  if (is_grasping(state, env, kPegProp)) {
    const Vec2 shift = Vec2(goal.x, goal.y) - peg.center;
    const double turn = std::abs(goal.turn) < kTurnedWithin ? 0.0 : goal.turn;
    if (turn == 0) {
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
  const bool low = tcp.z() < 0.055 && offset.norm() < 0.03;
  const double wanted = low ? yaw : grasp_yaw(peg, goal.turn);
  const bool ready = low || (std::abs(wrap_angle(wanted - yaw)) < 0.06 && offset.norm() < 0.008 &&
                             misaligned < 0.55);
  const double height = ready ? kGraspHeight : kHoverHeight;
  const bool close = low && tcp.z() < kGraspHeight + 0.01;
  servo_tool(state, env, {peg.center.x(), peg.center.y(), height}, tool_down(wanted),
             close ? kGripperSqueezing : kGripperOpen, action);
}

}  // namespace engram::tasks
