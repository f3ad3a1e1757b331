#include "tasks/intercept/ball_catcher.h"

#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"
#include "tasks/common/tool_servo.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kControlStep = 0.05;   // s
constexpr double kTopSpeed = 0.033;     // m per control step that the hand can count on
constexpr double kReactionSteps = 2;    // until the hand is up to speed
constexpr double kBaseX = -0.615;       // m: axis of the robot's base
constexpr double kFarthest = 0.76;      // m from there
constexpr double kTrackingGain = 0.45;  // share of the error that a step removes

// What follows from the size of the ball, m.
struct Catch {
  explicit Catch(double radius)
      : hover_height(2 * radius + 0.028),
        grip_height(radius + 0.002),
        low(2 * radius + 0.01),
        descend_within(0.016 - (radius - BALL_RADIUS)),
        close_within(0.014 - (radius - BALL_RADIUS)) {}

  double hover_height;  // the fingertips just clear the ball
  double grip_height;
  double low;  // beside the ball already
  double
      descend_within;  // error along the path at which to come down; open fingers leave that room
  double close_within;
};

Vector at(const double* values) { return Eigen::Map<const Vector>(values); }

// Where the hand can first be above the ball, and how many control steps from now.
Vector meeting_point(const Vector& ball, const Vector& velocity, const Vector& tcp, double height) {
  constexpr int kLongest = 60;
  Vector point = ball;
  for (int step = 1; step <= kLongest; ++step) {
    point = ball + kControlStep * step * velocity;
    point.z() = height;
    const double reach = real::hypot(point.x() - kBaseX, point.y());
    const double steps = (point - tcp).norm() / kTopSpeed + kReactionSteps;
    if (reach <= kFarthest && steps <= step) break;
  }
  return point;
}

}  // namespace

bool holds_ball(const State& state, int env, double radius) {
  if (is_grasping(state, env, kBallProp)) return true;
  const Vector offset = at(state.prop_pos_of(env, kBallProp)) - at(state.tcp_pos.row(env));
  const double* fingers = state.qpos.row(env) + kArmJoints;
  return offset.head<2>().norm() < 0.015 && std::abs(offset.z()) < 0.012 &&
         fingers[0] + fingers[1] < 2 * radius + 0.004;
}

void catch_ball(const State& state, int env, double radius, float* action) {
  const Catch sizes(radius);
  const Vector ball = at(state.prop_pos_of(env, kBallProp));
  Vector velocity = at(state.prop_qvel_of(env, kBallProp));
  velocity.z() = 0;
  const Vector tcp = at(state.tcp_pos.row(env));

  // Run along with the ball, or wait for it where the hand can join it.
  const Vector error = ball - tcp;
  Vector command = (kControlStep * velocity + kTrackingGain * error) / kStepResponse;
  const double lead = 0.03 + 2.5 * kControlStep * velocity.y();
  if (-error.y() > lead) {
    const Vector meeting = meeting_point(ball, velocity, tcp, sizes.hover_height);
    command.y() = std::max(command.y(), (meeting.y() - tcp.y()) / kStepResponse);
  }

  const bool above = std::abs(error.y()) < sizes.descend_within && std::abs(error.x()) < 0.008;
  const bool around =
      above && std::abs(error.y()) < sizes.close_within && tcp.z() < sizes.grip_height + 0.012;
  const bool low = tcp.z() < sizes.low && std::abs(error.y()) < 0.03;
  const double height = above || low ? sizes.grip_height : sizes.hover_height;
  command.z() = 1.6 * (height - tcp.z());
  move_tool(state, env, command, tool_down(0), around ? kGripperSqueezing : kGripperOpen, action);
}

}  // namespace engram::tasks
