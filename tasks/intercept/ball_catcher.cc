#include "tasks/intercept/ball_catcher.h"

#include <algorithm>
#include <cmath>

#include "core/base/real_functions.h"
#include "tasks/parts/tool_servo.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kControlStep = 0.05;     // s
constexpr double kTopSpeed = 0.033;       // m per control step that the hand can count on
constexpr double kReactionSteps = 2;      // until the hand is up to speed
constexpr double kBaseX = -0.615;         // m: axis of the robot's base
constexpr double kFarthest = 0.76;        // m from there
constexpr double kHoverHeight = 0.068;    // m: the fingertips just clear the ball
constexpr double kGripHeight = 0.022;     // m
constexpr double kTrackingGain = 0.45;    // share of the error that a step removes
constexpr double kDescendWithin = 0.016;  // m: error along the path at which to come down
constexpr double kCloseWithin = 0.014;

Vector at(const double* values) { return Eigen::Map<const Vector>(values); }

// Where the hand can first be above the ball, and how many control steps from now.
Vector meeting_point(const Vector& ball, const Vector& velocity, const Vector& tcp) {
  constexpr int kLongest = 60;
  Vector point = ball;
  for (int step = 1; step <= kLongest; ++step) {
    point = ball + kControlStep * step * velocity;
    point.z() = kHoverHeight;
    const double reach = real::hypot(point.x() - kBaseX, point.y());
    const double steps = (point - tcp).norm() / kTopSpeed + kReactionSteps;
    if (reach <= kFarthest && steps <= step) break;
  }
  return point;
}

}  // namespace

bool holds_ball(const State& state, int env) {
  if (is_grasping(state, env, kBallProp)) return true;
  const Vector offset = at(state.prop_pos_of(env, kBallProp)) - at(state.tcp_pos.row(env));
  const double* fingers = state.qpos.row(env) + kArmJoints;
  return offset.head<2>().norm() < 0.015 && std::abs(offset.z()) < 0.012 &&
         fingers[0] + fingers[1] < 2 * BALL_RADIUS + 0.004;
}

void catch_ball(const State& state, int env, float* action) {
  const Vector ball = at(state.prop_pos_of(env, kBallProp));
  Vector velocity = at(state.prop_qvel_of(env, kBallProp));
  velocity.z() = 0;
  const Vector tcp = at(state.tcp_pos.row(env));

  // Run along with the ball, or wait for it where the hand can join it.
  const Vector error = ball - tcp;
  Vector command = (kControlStep * velocity + kTrackingGain * error) / kStepResponse;
  const double lead = 0.03 + 2.5 * kControlStep * velocity.y();
  if (-error.y() > lead) {
    const Vector meeting = meeting_point(ball, velocity, tcp);
    command.y() = std::max(command.y(), (meeting.y() - tcp.y()) / kStepResponse);
  }

  const bool above = std::abs(error.y()) < kDescendWithin && std::abs(error.x()) < 0.008;
  const bool around = above && std::abs(error.y()) < kCloseWithin && tcp.z() < kGripHeight + 0.012;
  const bool low = tcp.z() < 0.05 && std::abs(error.y()) < 0.03;
  const double height = above || low ? kGripHeight : kHoverHeight;
  command.z() = 1.6 * (height - tcp.z());
  move_tool(state, env, command, tool_down(0), around ? kGripperSqueezing : kGripperOpen, action);
}

}  // namespace engram::tasks
