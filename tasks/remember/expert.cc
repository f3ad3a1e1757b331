#include "tasks/remember/expert.h"

#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/common/tcp_servo.h"
#include "tasks/common/tour.h"

namespace engram::tasks {
namespace {

constexpr double kTouchGap = 0.017;  // m above an object as high as a cube
// Objects that would roll away from a touch are approached more slowly, up to a gap.
constexpr double kRollingGap = 0.020;  // m
// m: how much nearer than GOAL_THRESH the tool goes. Where that is into the object, the gripper
// opens to reach around it.
constexpr double kTouchMargin = 0.008;
constexpr double kGently = 0.65;        // of the usual speed
constexpr double kTravelGap = 0.06;     // m more during the approach
constexpr double kCloseEnough = 0.010;  // m
// The farthest slots of all are out of a vertical tool's reach.
constexpr Tilt kTilt{.reach = 0.78, .per_metre = 5.0, .most = 0.4};

}  // namespace

void ObjectRecallExpert::act(Range envs, Script script, FloatRows actions) const {
  for (int env = envs.begin; env < envs.end; ++env) {
    float* action = actions.row(env);
    if (script == Script::kSweep) {
      sweep(env, action);
    } else {
      touch(env, script == Script::kBlind ? guess(env) : view_.target[env], action);
    }
  }
}

// Keeps above the object's stored place until it is nearly overhead, then comes down to touch.
void ObjectRecallExpert::touch(int env, int key, float* action) const {
  const State& state = *view_.engine.state;
  const bool rolls = view_.objects.rolls(key);
  const Eigen::Vector3d touch = Eigen::Map<const Eigen::Vector3d>(position(env, key)) +
                                Eigen::Vector3d(0, 0, touch_height(rolls));
  const Eigen::Map<const Eigen::Vector3d> tcp(state.tcp_pos.row(env));
  const double gripper = gripper_for(env, key);
  if (!is_manipulation(env) || (tcp - touch).norm() < kCloseEnough) {
    hold_tcp(gripper, action);
    return;
  }
  Eigen::Vector3d goal = approach_from_above(state, env, touch, kTravelGap);
  if (rolls) goal.z() = std::lerp(tcp.z(), goal.z(), kGently);
  servo_tcp(state, env, goal, tilt_outwards(kToolDown, touch, kTilt), gripper, action);
}

// Without memory: rests over one object after the other, or passes over them where that is enough.
void ObjectRecallExpert::sweep(int env, float* action) const {
  const State& state = *view_.engine.state;
  if (!is_manipulation(env)) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  Tour tour;
  for (int key = 0; key < view_.objects.count(); ++key) {
    const double height = touch_height(view_.objects.rolls(key));
    tour.add(prop_pos(state, env, key) + Eigen::Vector3d(0, 0, height));
  }
  const Tour::Target next = tour.next(state, env,
                                      {.reach = sweep_reach(),
                                       .again = !view_.info.frozen_cue,
                                       .rests = view_.touch.static_needed()});
  if (next.rest) {
    hold_tcp(kGripperClosed, action);
  } else {
    servo_tcp(state, env, next.goal, tilt_outwards(kToolDown, next.goal, kTilt), kGripperClosed,
              action);
  }
}

// Height of a touch above an object's origin, m.
double ObjectRecallExpert::touch_height(bool rolls) const {
  return std::min(view_.objects.size() + (rolls ? kRollingGap : kTouchGap),
                  view_.goal_thresh - kTouchMargin);
}

// Distance from a touch point in which the tool may rest and still be within GOAL_THRESH, m.
double ObjectRecallExpert::sweep_reach() const {
  constexpr double kMargin = 0.005;  // m
  const double height = touch_height(false);
  const double radius = std::max(view_.goal_thresh - kMargin, height);
  return std::max(0.01, std::sqrt(radius * radius - height * height));
}

// The original's demonstrations keep the gripper open while they wait, and in the Long ids to the
// end. Where there is no room for that, it closes on the last part of the approach.
double ObjectRecallExpert::gripper_for(int env, int key) const {
  constexpr double kNear = 0.12;  // m
  if (!is_manipulation(env)) return kGripperOpen;
  if (touch_height(false) < view_.objects.size() + kTouchGap) return kGripperOpen;
  if (view_.info.frozen_cue) return kGripperClosed;
  const double* at = position(env, key);
  const Eigen::Vector3d tcp = tcp_pos(*view_.engine.state, env);
  const bool near = real::hypot(tcp.x() - at[0], tcp.y() - at[1]) < kNear;
  return near && is_crowded(env, key) ? kGripperClosed : kGripperOpen;
}

// True if open fingers that come down on an object, which they close along y, would meet another.
bool ObjectRecallExpert::is_crowded(int env, int key) const {
  constexpr double kBesideX = 0.05;  // m, from origin to origin
  constexpr double kBesideY = 0.10;
  const double* at = position(env, key);
  for (int other = 0; other < view_.objects.count(); ++other) {
    const double* pos = position(env, other);
    if (other != key && std::abs(pos[0] - at[0]) < kBesideX &&
        std::abs(pos[1] - at[1]) < kBesideY) {
      return true;
    }
  }
  return false;
}

// Object that an agent without memory would touch, or that the caller has chosen.
int ObjectRecallExpert::guess(int env) const {
  return choice_or(
      env, [&] { return guess_stream(view_.engine, env).integer(0, view_.objects.count() - 1); });
}

ChoiceForm ObjectRecallExpert::choice_form() const {
  ChoiceForm form{.question = "Which object is to be touched?"};
  for (int key = 0; key < view_.objects.count(); ++key) {
    form.items.push_back("the " + view_.objects.name(key));
  }
  return form;
}

}  // namespace engram::tasks
