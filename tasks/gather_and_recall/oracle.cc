#include "tasks/gather_and_recall/oracle.h"

#include <algorithm>
#include <cmath>

#include "tasks/common/poses.h"
#include "tasks/gather_and_recall/rules.h"

namespace engram::tasks {
namespace {

constexpr double kTableHeight = 0.05;   // m, of the TCP: where the tool is slowest
constexpr double kTravelHeight = 0.13;  // m: a cube in the hand passes over all others
constexpr double kClearance = 0.06;     // m above a cube that was left
constexpr double kHasteHeight = 0.1;    // m: enough to clear a cube that was dropped
constexpr double kNearButtons = 0.07;   // m: how much nearer to the buttons a single cube goes
constexpr double kNearRim = 0.03;       // m
constexpr double kOpening = 0.44;       // 26 mm per finger: clear of the neighbours
constexpr Lean kLean{.reach = 0.77, .per_metre = 4.0, .most = 0.12};

Eigen::Vector3d place_of(int cube, const Vec2& disc) {
  const Vec2 place = disc + place_on_disc(cube);
  return {place.x(), place.y(), kOnDisc};
}

bool has_landed(const Eigen::Vector3d& cube, const Vec2& disc, double threshold) {
  constexpr double kRim = 0.005;  // m
  const Eigen::Vector3d offset = cube - Eigen::Vector3d(disc.x(), disc.y(), kOnDisc);
  return offset.head<2>().norm() < threshold - kRim && std::abs(offset.z()) < kRim;
}

// Only the cube between the fingers has to be left; others may stand close by.
bool leave_cube(const State& state, int env, const Grip& grip, float* action) {
  constexpr double kBetweenFingers = 0.02;  // m
  const Eigen::Vector3d offset = prop_pos(state, env, grip.prop) - tcp_pos(state, env);
  if (offset.head<2>().norm() > kBetweenFingers) return true;
  return leave(state, env, grip, kClearance, action);
}

}  // namespace

void GatherOracle::act(const State& state, int env, const GatherGoal& goal, float* action) const {
  if (bring_cubes(state, env, goal.disc, action)) press(state, env, goal, action);
  slow_down(state, env, kTableHeight, action);
}

void GatherOracle::sweep(const State& state, int env, const Vec2& disc, int shown,
                         float* action) const {
  if (shown >= 0 && all_over(state, env, disc)) {
    drop_and_press(state, env, shown, action);
    return;
  }
  // A single cube lights the lamp itself: near the buttons there is time to follow the lamp.
  const double nearer = cubes_ == 1 ? std::clamp(threshold_ - kNearRim, 0.0, kNearButtons) : 0.0;
  if (bring_cubes(state, env, disc - Vec2(nearer, 0), action)) {
    press(state, env, {disc, nearest_button(env), false}, action);
  }
  slow_down(state, env, kTableHeight, action);
}

bool GatherOracle::bring_cubes(const State& state, int env, const Vec2& disc, float* action) const {
  for (int cube = 0; cube < cubes_; ++cube) {
    const Eigen::Vector3d place = place_of(cube, disc);
    const Eigen::Vector3d pos = prop_pos(state, env, cube);
    Grip grip{.prop = cube, .opening = kOpening, .travel_height = kTravelHeight};
    if (!is_held(state, env, cube)) {
      grip.tool = lean_outwards(tool_for_cube(state, env, cube), pos, kLean);
      if (has_landed(pos, disc, threshold_)) {
        if (!leave_cube(state, env, grip, action)) return false;
        continue;
      }
    } else {
      grip.tool = lean_outwards(kToolDown, place, kLean);
    }
    if (!bring(state, env, grip, place, action)) return false;
  }
  return true;
}

void GatherOracle::press(const State& state, int env, const GatherGoal& goal, float* action) const {
  if (goal.pressed) {
    hold_tool(kGripperClosed, action);
    return;
  }
  const PressButton& button = buttons_[static_cast<std::size_t>(goal.color)];
  const Eigen::Vector3d waypoint = button.next_waypoint(env, kTravelHeight);
  servo_tool(state, env, over_the_top(state, env, waypoint, kTravelHeight), kToolDown,
             kGripperClosed, action);
}

void GatherOracle::drop_and_press(const State& state, int env, int color, float* action) const {
  for (int cube = 0; cube < cubes_; ++cube) {
    if (!is_grasping(state, env, cube)) continue;
    hold_tool(kGripperOpen, action);
    return;
  }
  const PressButton& button = buttons_[static_cast<std::size_t>(color)];
  servo_tool(state, env, button.next_waypoint(env, kHasteHeight), kToolDown, kGripperOpen, action);
}

bool GatherOracle::all_over(const State& state, int env, const Vec2& disc) const {
  for (int cube = 0; cube < cubes_; ++cube) {
    if ((prop_pos(state, env, cube).head<2>() - disc).norm() >= threshold_) return false;
  }
  return true;
}

int GatherOracle::nearest_button(int env) const {
  const auto distance = [env](const PressButton& button) { return button.distance(env); };
  return static_cast<int>(std::ranges::min_element(buttons_, {}, distance) - buttons_.begin());
}

}  // namespace engram::tasks
