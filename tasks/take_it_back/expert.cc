#include "tasks/take_it_back/expert.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/observe/object_words.h"
#include "tasks/common/guess_stream.h"
#include "tasks/common/poses.h"
#include "tasks/common/tcp_servo.h"
#include "tasks/take_it_back/layout.h"

namespace engram::tasks {
namespace {

using Vec2 = Eigen::Vector2d;
using Vector = Eigen::Vector3d;

constexpr double kCloseEnough = 0.03;  // m: of the start, for letting go
constexpr double kWellInside = 0.6;    // of the radius
constexpr double kMinHeight = 0.014;   // m, of the grip: the fingertips clear the table
constexpr double kTravelGap = 0.04;    // m above the cube during the approach
constexpr double kCarryGap = 0.015;    // m above a cube on the table
constexpr double kNearPart = 0.85;     // of the radius, from the target's centre
// m, along x: beyond, the arm is nearly straight, and a small step of the TCP takes large ones of
// the joints.
constexpr double kFarthest = 0.21;
constexpr int kMiddle = 1;  // key of the slot in the middle

}  // namespace

void TakeItBackExpert::act(Range envs, Script script, FloatRows actions) const {
  const State& state = *view_.engine.state;
  const double close_enough = std::min(kCloseEnough, kWellInside * view_.goal_radius);
  for (int env = envs.begin; env < envs.end; ++env) {
    const Vec2 place = home(env, script);
    float* action = actions.row(env);
    const bool returned = script != Script::kSweep && view_.reached[env] != 0 &&
                          (prop_pos(state, env, kCube).head<2>() - place).norm() < close_enough;
    if (!is_grasping(state, env, kCube)) {
      grasp_cube(env, returned, action);
    } else if (returned) {
      hold_tcp(kGripperOpen, action);
    } else {
      carry_cube(env, place, action);
    }
  }
}

void TakeItBackExpert::grasp_cube(int env, bool let_go, float* action) const {
  const State& state = *view_.engine.state;
  Vector at = prop_pos(state, env, kCube);
  at.z() = std::max(at.z(), kMinHeight);
  const Vector offset = at - tcp_pos(state, env);
  const bool around = offset.norm() < 0.012;
  if (let_go) {
    hold_tcp(kGripperOpen, action);
    return;
  }
  servo_tcp(state, env, approach_from_above(state, env, at, view_.cube_halfsize + kTravelGap),
            tilt_outwards(kToolDown, at), around ? kGripperSqueezing : kGripperOpen, action);
}

void TakeItBackExpert::carry_cube(int env, const Vec2& home, float* action) const {
  const State& state = *view_.engine.state;
  const bool asks = awaits_choice(env);
  if (view_.reached[env] != 0 && !is_to_return(env) && !asks) {  // the target will change colour
    hold_tcp(kGripperSqueezing, action);
    return;
  }
  const Vec2 goal = Eigen::Map<const Vec2>(view_.goal.row(env));
  const Vec2 near_part = goal + kNearPart * view_.goal_radius * (home - goal).normalized();
  const Vec2 there = asks ? neutral_way(env) : near_part;
  const Vec2 back = is_asked(env) && is_beside_way(env, home) ? near_part : home;
  const Vec2 next = view_.reached[env] != 0 && !asks ? back : there;
  const Vector waypoint(next.x(), next.y(), view_.cube_halfsize + kCarryGap);
  servo_tcp(state, env, waypoint, tilt_outwards(kToolDown, waypoint), kGripperSqueezing, action);
}

bool TakeItBackExpert::is_to_return(int env) const {
  const State& state = *view_.engine.state;
  return view_.reached[env] != 0 && state.status_of(env, kChangedGoalRegion) != PropStatus::kHidden;
}

ChoiceForm TakeItBackExpert::choice_form() const {
  const char* const words[kSlots] = {"on the left", "in the middle", "on the right"};
  ChoiceForm form{.question = "Where was the cube first?"};
  for (int key = 0; key < kSlots; ++key) {  // left as in images
    form.items.push_back(words[key] + std::string(", near y ") +
                         in_metres(middle_of_slot(key - kMiddle).y()));
  }
  return form;
}

bool TakeItBackExpert::is_choice_due(int env) const {
  return awaits_choice(env) && is_to_return(env);
}

// True on the target, apart from the straight way from its centre to a place, which is the
// oracle's.
bool TakeItBackExpert::is_beside_way(int env, const Vec2& place) const {
  constexpr double kApart = 0.01;  // m
  const Vec2 goal = Eigen::Map<const Vec2>(view_.goal.row(env));
  const Vec2 offset = prop_pos(*view_.engine.state, env, kCube).head<2>() - goal;
  const Vec2 way = (place - goal).normalized();
  return offset.norm() < view_.goal_radius &&
         std::abs(offset.x() * way.y() - offset.y() * way.x()) > kApart;
}

// The next point on a way to the target that ends along x: where the cube reaches the target does
// not tell where it comes from.
Vec2 TakeItBackExpert::neutral_way(int env) const {
  constexpr double kAligned = 0.004;  // m
  constexpr double kRoom = 0.015;     // m before the target
  const Vec2 goal = Eigen::Map<const Vec2>(view_.goal.row(env));
  const double cube_y = prop_pos(*view_.engine.state, env, kCube).y();
  const bool aligned = std::abs(cube_y - goal.y()) < kAligned;
  if (!aligned) return goal - Vec2(view_.goal_radius + kRoom, 0);
  return {std::min(goal.x(), kFarthest), goal.y()};
}

// The cube's first place, or the same in another slot.
Vec2 TakeItBackExpert::chosen_home(int env) const {
  const int slot = choice_or(env, [&] { return view_.slot[env] + kMiddle; }) - kMiddle;
  return Eigen::Map<const Vec2>(view_.initial.row(env)) +
         Vec2(0, kSlotPitch * (slot - view_.slot[env]));
}

// Place to which the cube is brought back.
Vec2 TakeItBackExpert::home(int env, Script script) const {
  switch (script) {
    case Script::kOracle:
      return Eigen::Map<const Vec2>(view_.initial.row(env));
    case Script::kBlind:
      if (is_asked(env)) return chosen_home(env);
      return middle_of_slot(guess_stream(view_.engine, env).integer(-1, 1));
    case Script::kSweep:
      break;
  }
  // First into the slot to the right, then through all of them.
  constexpr double kAmong = 0.03;  // m
  constexpr double kInside = 0.015;
  const bool among = prop_pos(*view_.engine.state, env, kCube).x() < kAmong;
  return middle_of_slot(among ? 1 : -1) + Vec2(0, among ? -kInside : kInside);
}

}  // namespace engram::tasks
