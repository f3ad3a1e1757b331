#include "tasks/trace_shape/oracle.h"

#include <algorithm>

#include "tasks/parts/grasp_servo.h"
#include "tasks/parts/poses.h"

namespace engram::tasks {
namespace {

constexpr double kTakeHeight = 0.12;   // m, of the TCP on the way to the cube
constexpr double kTraceHeight = 0.06;  // m, of the TCP while it carries the cube

// The red cube may have pushed the green one where a vertical tool cannot follow.
constexpr Lean kLean{.fold = 0.33};

// The centre of the button, pulled towards the robot as far as the press radius allows where it is
// hard to reach.
Vec2 press_point(const Vec2& center) {
  constexpr double kEasyReach = 0.75;  // m
  constexpr double kMostPull = 0.055;  // m
  const Vec2 base(kRobotBaseX, 0);
  const Vec2 outward = center - base;
  const double reach = outward.norm();
  const double pull = std::clamp(reach - kEasyReach, 0.0, kMostPull);
  return base + outward * ((reach - pull) / reach);
}

}  // namespace

void trace_contour(const State& state, int env, int cube, const Contour& contour, int visited,
                   float* action) {
  const Eigen::Vector3d pos = prop_pos(state, env, cube);
  Grip grip{.prop = cube,
            .tool = lean_outwards(tool_for_cube(state, env, cube), pos, kLean),
            .travel_height = kTakeHeight};
  if (!take(state, env, grip, action)) return;
  const double in_hand = state.tcp_pos.row(env)[2] - pos.z();
  grip.travel_height = kTraceHeight;
  const Vec2 goal = contour.checkpoint(contour.set().next_checkpoint(visited));
  carry(state, env, grip, {goal.x(), goal.y(), kTraceHeight - in_hand}, action);
}

void submit_trace(const State& state, int env, int cube, const PressButton& button, float* action) {
  constexpr double kClearance = 0.06;     // m, of the TCP above the cube
  constexpr double kPressHeight = 0.075;  // m, of the TCP: nearly the full travel
  constexpr double kTravelHeight = 0.16;  // m
  const Eigen::Quaterniond tool = tool_down(tool_yaw(state, env));
  const Grip grip{.prop = cube, .tool = lean_outwards(tool, prop_pos(state, env, cube))};
  if (!leave(state, env, grip, kClearance, action)) return;
  const Vec2 at = press_point(button.center(env));
  const Eigen::Vector3d goal(at.x(), at.y(), kPressHeight);
  steer_tool(state, env, over_the_top(state, env, goal, kTravelHeight), lean_outwards(tool, goal),
             kGripperOpen, action);
}

void await_demo(float* action) {
  constexpr double kAsWideAsTheCube = 0.22;  // 20.5 mm per finger
  hold_tool(kAsWideAsTheCube, action);
}

}  // namespace engram::tasks
