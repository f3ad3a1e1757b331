#include "tasks/rotate/expert.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/common/tcp_servo.h"
#include "tasks/rotate/peg_angle.h"

namespace engram::tasks {
namespace {

using Vec2 = Eigen::Vector2d;
using Vector = Eigen::Vector3d;

constexpr double kUsualThreshold = 0.1;  // rad

// Pose of the peg: centre, and unit vectors along and across it.
struct Peg {
  Vec2 center;
  double yaw;
  Vec2 along;
  Vec2 across;
};

Peg measure_peg(const State& state, int env) {
  const double* pos = state.prop_pos_of(env, kPeg);
  const double yaw = peg_angle(state.prop_quat_of(env, kPeg));
  return {
      {pos[0], pos[1]}, yaw, {real::cos(yaw), real::sin(yaw)}, {-real::sin(yaw), real::cos(yaw)}};
}

// --- pushing ---

constexpr double kApproachGap = 0.025;  // m beside the peg
constexpr double kStopWithin = 0.035;   // rad, where the threshold is the usual one
constexpr double kMinAdvance = 0.008;   // m: less would not overcome the peg's friction
constexpr double kPushAdvance = 0.038;  // m: at most, by which a step's goal is ahead

// Lengths that follow from the size of the peg, m.
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
  double inner;          // along the peg, from where on a contact turns it
  double outer;
  double drift;  // per rad: how far a push carries the centre along
};

// Half the size of the closed fingertips along a direction.
double finger_extent(const Vec2& direction) {
  return 0.00875 * std::abs(direction.x()) + 0.0152 * std::abs(direction.y());
}

// Position of the fingers against the peg's side to push the end `end` (+1 or -1), when the peg is
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

void RotateExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    const bool sweeps = script == Script::kSweep;
    const Goal goal = sweeps ? timed_goal(env) : measured_goal(env, script);
    if (view_.strict || sweeps) {
      turn_peg(env, goal, actions.row(env));
    } else {
      push_peg(env, goal, actions.row(env));
    }
  }
}

RotateExpert::Goal RotateExpert::measured_goal(int env, Script script) const {
  const double target = script == Script::kBlind ? guess(env) : view_.target[env];
  const double angle = peg_angle(view_.engine.state->prop_quat_of(env, kPeg));
  return {.turn = peg_turn(angle, view_.initial_yaw[env], target).error,
          .x = view_.initial_position.row(env)[0],
          .y = view_.initial_position.row(env)[1]};
}

// Without memory of the first pose: begins at a set step, turns the peg at full speed and stops
// when that should have been enough.
RotateExpert::Goal RotateExpert::timed_goal(int env) const {
  constexpr double kPerStep = 0.0387;  // rad
  constexpr int kLatestStart = 42;     // control steps, by when the peg is always in hand
  constexpr int kRest = 3;             // ... at the end
  const State& state = *view_.engine.state;
  const double size = std::abs(view_.target[env]);
  const int steps = static_cast<int>(std::lrint(size / kPerStep));
  const int start = std::min(kLatestStart, view_.info.horizon - kRest - steps);
  const int since = state.elapsed[env] - start;
  const Vector peg = prop_pos(state, env, kPeg);
  return {.turn = since < steps ? view_.target[env] : 0.0,
          .wait = since < 0,
          .x = peg.x(),
          .y = peg.y()};
}

// Turn of an agent that has not read the target.
double RotateExpert::guess(int env) const {
  RandomStream random = guess_stream(view_.engine, env);
  return target_angle(view_.mode, view_.threshold, random.uniform());
}

void RotateExpert::push_peg(int env, const Goal& goal, float* action) const {
  const State& state = *view_.engine.state;
  const Push sizes(view_.peg);
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double sign = goal.turn < 0 ? -1 : 1;
  if (std::abs(goal.turn) < kStopWithin * (view_.threshold / kUsualThreshold)) {
    hold_tcp(kGripperClosed, action);
    return;
  }
  // Position of the hand in the peg's frame.
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
        std::clamp(gap + 0.5 * sizes.lever * std::abs(goal.turn), kMinAdvance, kPushAdvance);
    const Vec2 command =
        advance * push / kStepResponse * 0.6 + 0.8 * (end * sizes.lever - along) * peg.along;
    displace_tcp(state, env, {command.x(), command.y(), 1.6 * (sizes.height - tcp.z())},
                 tilt_outwards(kToolDown, tcp), kGripperClosed, action);
    return;
  }
  const int chosen = easier_end(peg, sizes, goal.turn, tcp);
  const Vec2 start = contact_point(peg, sizes, chosen, sign, kApproachGap);
  const bool overhead = (start - tcp.head<2>()).norm() < 0.02;
  const Vector waypoint(start.x(), start.y(), overhead ? sizes.height : sizes.travel_height);
  servo_tcp(state, env, waypoint, tilt_outwards(kToolDown, waypoint), kGripperClosed, action);
}

// --- grasping and turning ---

namespace {

constexpr double kGraspGap = 0.002;  // m above the peg's axis
constexpr double kHoverGap = 0.025;  // m above the peg: the open fingertips clear it
constexpr double kLowGap = 0.005;    // m above the peg: the fingertips are beside it
// Rad, where the open fingers leave the usual room on both sides of the peg.
constexpr double kMaxMisalignment = 0.3;  // the closing fingers turn the peg by as much
constexpr double kMayComeDown = 0.55;
constexpr double kFingerOpening = 0.04;  // m to either side
constexpr double kUsualRoom = 0.015;     // m
constexpr double kMinYaw = -2.0;         // rad: what the wrist can do
constexpr double kMaxYaw = 3.5;
constexpr double kTurnedWithin = 0.03;  // rad, where the threshold is the usual one

// Yaw of the hand for a grasp: across the peg, turned ahead by at most `most` in the direction of
// the target.
double grasp_yaw(const Peg& peg, double turn, double most) {
  const double ahead = std::clamp(turn, -most, most);
  double best = 0;
  double least = std::numeric_limits<double>::max();
  for (int k = -3; k <= 3; ++k) {
    const double yaw = peg.yaw + ahead + k * kPi;
    const double last = yaw + turn - ahead;
    if (std::min(yaw, last) < kMinYaw || std::max(yaw, last) > kMaxYaw) continue;
    const double cost = std::abs(yaw);
    if (cost < least) {
      least = cost;
      best = yaw;
    }
  }
  return best;
}

}  // namespace

void RotateExpert::turn_peg(int env, const Goal& goal, float* action) const {
  const State& state = *view_.engine.state;
  const double grasp_height = view_.peg.half_width + kGraspGap;
  const double peg_height = 2 * view_.peg.half_width;
  const double room = std::min(1.0, (kFingerOpening - view_.peg.half_width) / kUsualRoom);
  const Peg peg = measure_peg(state, env);
  const Vector tcp = tcp_pos(state, env);
  const double yaw = tcp_yaw(state, env);
  if (is_grasping(state, env, kPeg)) {
    const Vec2 shift = Vec2(goal.x, goal.y) - peg.center;
    const double turn =
        std::abs(goal.turn) < kTurnedWithin * (view_.threshold / kUsualThreshold) ? 0.0 : goal.turn;
    if (turn == 0 || goal.wait) {
      hold_tcp(kGripperSqueezing, action);
    } else {
      displace_tcp(state, env, {shift.x(), shift.y(), 0}, tool_down(yaw + turn), kGripperSqueezing,
                   action);
    }
    return;
  }
  const Vec2 offset = peg.center - tcp.head<2>();
  // While it descends and closes, the hand keeps its yaw.
  const double misaligned = std::abs(wrap_angle(2 * (yaw - peg.yaw)) / 2);
  const bool low = tcp.z() < peg_height + kLowGap && offset.norm() < 0.03;
  const double max_ahead = goal.wait ? 0 : kMaxMisalignment * room;
  const double wanted = low ? yaw : grasp_yaw(peg, goal.turn, max_ahead);
  const bool ready = low || (std::abs(wrap_angle(wanted - yaw)) < 0.06 && offset.norm() < 0.008 &&
                             misaligned < kMayComeDown * room);
  const double height = ready ? grasp_height : peg_height + kHoverGap;
  const bool close = low && tcp.z() < grasp_height + 0.01;
  servo_tcp(state, env, {peg.center.x(), peg.center.y(), height}, tool_down(wanted),
            close ? kGripperSqueezing : kGripperOpen, action);
}

}  // namespace engram::tasks
