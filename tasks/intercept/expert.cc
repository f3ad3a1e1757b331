#include "tasks/intercept/expert.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"
#include "tasks/common/poses.h"
#include "tasks/common/tcp_servo.h"

namespace engram::tasks {
namespace {

using Vector = Eigen::Vector3d;

constexpr double kStepTime = 0.05;      // s
constexpr double kTopSpeed = 0.033;     // m per control step that the hand can count on
constexpr double kReactionSteps = 2;    // until the hand is up to speed
constexpr double kFarthest = 0.76;      // m from the axis of the robot's base
constexpr double kStretched = 0.82;     // m, likewise: farther away the arm is out of control
constexpr double kTrackingGain = 0.45;  // share of the error that a step removes

// Half the size of the closed fingertips along the ball's path, m.
constexpr double kTipExtent = 0.0152;

// Lengths that follow from the size of the ball, m.
struct Catch {
  explicit Catch(double radius)
      : contact_distance(radius + kTipExtent),
        clear_height(2 * radius + 0.014),
        hover_height(2 * radius + 0.028),
        grip_height(radius + 0.002),
        low(2 * radius + 0.01),
        descend_within(0.016 - (radius - BALL_RADIUS)),
        close_within(0.014 - (radius - BALL_RADIUS)) {}

  double contact_distance;  // from the ball to closed fingers that it touches
  double clear_height;      // the fingertips just clear the ball
  double hover_height;      // so they do with some room
  double grip_height;
  double low;  // beside the ball already
  // Error along the path at which to come down; open fingers leave that room.
  double descend_within;
  double close_within;
};

double reach_of(const Vector& point) { return real::hypot(point.x() - kRobotBaseX, point.y()); }

// First point in which the hand can be above the ball.
Vector meeting_point(const Vector& ball, const Vector& velocity, const Vector& tcp, double height) {
  constexpr int kLongest = 60;
  Vector point = ball;
  for (int step = 1; step <= kLongest; ++step) {
    point = ball + kStepTime * step * velocity;
    point.z() = height;
    const double reach = reach_of(point);
    const double steps = (point - tcp).norm() / kTopSpeed + kReactionSteps;
    if (reach <= kFarthest && steps <= step) break;
  }
  return point;
}

// True while the closed fingers have the ball between them.
bool holds_ball(const State& state, int env, double radius) {
  if (is_grasping(state, env, kBallProp)) return true;
  const Vector offset = prop_pos(state, env, kBallProp) - tcp_pos(state, env);
  const double* fingers = state.qpos.row(env) + kArmJoints;
  return offset.head<2>().norm() < 0.015 && std::abs(offset.z()) < 0.012 &&
         fingers[0] + fingers[1] < 2 * radius + 0.004;
}

// True if the ball lies within reach, or rolls there in the near future.
bool comes_within_reach(const Vector& ball, const Vector& velocity, const Vector& tcp) {
  return reach_of(ball) <= kStretched ||
         reach_of(meeting_point(ball, velocity, tcp, tcp.z())) <= kFarthest;
}

// --- blocking a fast ball ---

// Control steps that joint steps of 0.1 rad take from the start pose to a point on the table: elbow
// and wrist fold for points that are near, and stretch for those that are far; the wrist turns back
// what the base turns.
double steps_to(const Vector& point) {
  constexpr double kTurnPerStep = 0.038;  // rad
  const double reach = reach_of(point);
  const double folding = 32 - 50 * (reach - 0.25);
  const double stretching = 17 + 60 * (reach - 0.575);
  const double turning = real::atan2(std::abs(point.y()), point.x() - kRobotBaseX) / kTurnPerStep;
  return std::max({folding, stretching, turning});
}

// The point where the hand waits for a ball that is too fast to run along with: ahead of the first
// point of its path at which the hand arrives before it, or nearly so.
Vector blocking_point(const State& state, int env, const Vector& ball, const Vector& velocity,
                      const Catch& sizes) {
  constexpr int kLongest = 90;
  constexpr double kSpare = 8;  // control steps
  Vector best = ball;
  double least = std::numeric_limits<double>::infinity();
  for (int step = 1; step <= kLongest; ++step) {
    Vector point = ball + kStepTime * (step - state.elapsed[env]) * velocity;
    point.y() += sizes.contact_distance;
    point.z() = sizes.grip_height;
    if (reach_of(point) > kFarthest) continue;
    const double late = steps_to(point) + kSpare - step;
    if (late < least) {
      least = late;
      best = point;
    }
    if (late <= 0) break;
  }
  return best;
}

// Writes the next action towards a ball that the hand stops first. Returns false where it can be
// caught as any other.
bool stop_ball(const Bindings& engine, int env, const BallParams& params, const Vector& velocity,
               float* action) {
  const State& state = *engine.state;
  const Catch sizes(params.BALL_RADIUS);
  const Vector ball = prop_pos(state, env, kBallProp);
  const Vector tcp = tcp_pos(state, env);
  const Vector offset = ball - tcp;
  if (velocity.norm() > params.fastest_followed) {
    if (offset.y() > 0) return false;  // it has passed
    swing_tcp(state, *engine.arm, env, blocking_point(state, env, ball, velocity, sizes),
              tool_down(0), kGripperClosed, action);
    return true;
  }
  // The fingers go up beside the ball before they open and come down around it.
  constexpr double kMinGap = 0.005;  // m
  const double* fingers = state.qpos.row(env) + kArmJoints;
  const double width = fingers[0] + fingers[1];
  const bool open = width > 0.075;
  if (open) return false;
  if (tcp.z() < sizes.clear_height) {
    if (offset.head<2>().norm() < width / 2) return false;
    // Away from the ball first: fingers that rub along it would make it roll.
    const double gap = offset.head<2>().norm() - sizes.contact_distance;
    const double rise = gap < kMinGap ? 0 : 1.6 * (sizes.hover_height - tcp.z());
    displace_tcp(state, env, {0, gap < kMinGap ? 0.03 : 0, rise}, tool_down(0), kGripperClosed,
                 action);
    return true;
  }
  const Vector above(ball.x(), ball.y(), sizes.hover_height);
  servo_tcp(state, env, above, tool_down(0), kGripperOpen, action);
  return true;
}

// --- catching it ---

// Writes the next action towards a catch.
void catch_ball(const Bindings& engine, int env, const BallParams& params, float* action) {
  const State& state = *engine.state;
  const Catch sizes(params.BALL_RADIUS);
  const Vector ball = prop_pos(state, env, kBallProp);
  Vector velocity = Eigen::Map<const Vector>(state.prop_qvel_of(env, kBallProp));
  velocity.z() = 0;
  const Vector tcp = tcp_pos(state, env);
  if (params.stops_first() && stop_ball(engine, env, params, velocity, action)) return;
  if (params.may_rest() && !comes_within_reach(ball, velocity, tcp)) {
    hold_tcp(kGripperOpen, action);
    return;
  }

  // Run along with the ball, or wait for it where the hand can join it.
  const Vector error = ball - tcp;
  Vector command = (kStepTime * velocity + kTrackingGain * error) / kStepResponse;
  const double lead = 0.03 + 2.5 * kStepTime * velocity.y();
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
  displace_tcp(state, env, command, tool_down(0), around ? kGripperSqueezing : kGripperOpen,
               action);
}

}  // namespace

void GrabExpert::act(Range envs, Script /*script*/, FloatRows actions) const {
  const State& state = *engine_.state;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (holds_ball(state, env, ball_.BALL_RADIUS)) {
      hold_tcp(kGripperSqueezing, action);
    } else {
      catch_ball(engine_, env, ball_, action);
    }
  }
}

void DeflectExpert::act(Range envs, Script /*script*/, FloatRows actions) const {
  constexpr double kUsualRadius = 0.1;  // m, of a target in which a ball is brought
  constexpr double kNearEnough = 0.07;  // m, so near to the centre
  constexpr double kCarryGap = 0.005;   // m above a ball that rolls
  const State& state = *view_.engine.state;
  const double near_enough =
      std::max(kNearEnough + (view_.goal_radius - kUsualRadius), view_.goal_radius / 2);
  const double height = view_.ball.BALL_RADIUS + kCarryGap;
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    const Vector goal = prop_pos(state, env, view_.goal_prop);
    const Vector offset = prop_pos(state, env, kBallProp) - goal;
    if (!holds_ball(state, env, view_.ball.BALL_RADIUS)) {
      catch_ball(view_.engine, env, view_.ball, action);
    } else if (offset.head<2>().norm() < near_enough) {
      hold_tcp(kGripperSqueezing, action);
    } else {
      const Vector waypoint(goal.x(), goal.y(), height);
      servo_tcp(state, env, waypoint, kToolDown, kGripperSqueezing, action);
    }
  }
}

}  // namespace engram::tasks
