#include "tasks/trace_shape/oracle.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/math/real_functions.h"
#include "tasks/common/grasp_servo.h"
#include "tasks/common/poses.h"

namespace engram::tasks {
namespace {

constexpr double kTakeHeight = 0.12;   // m, of the TCP on the way to the cube
constexpr double kTraceHeight = 0.06;  // m, of the TCP while it carries the cube

// The red cube may have pushed the green one (red_pushes_green) where a vertical tool cannot
// follow.
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

// A ring and the way around it, +1 counter-clockwise.
struct RingCourse {
  double radius = 0;  // m
  int turn = 1;
};

// What is due at a step count: each ring has as many steps as it is long. Every other round
// turns the other way, so that the arm does not wind up.
RingCourse ring_course(const SweepRings& rings) {
  constexpr double kSure = 0.8;      // of the reach
  constexpr double kStride = 0.018;  // m per control step
  const double width = rings.most - rings.least;
  const int count = std::max(1, static_cast<int>(std::ceil(width / (2 * kSure * rings.reach))));
  const auto radius = [&](int ring) { return rings.least + width * (ring + 0.5) / count; };
  const auto steps = [&](int ring) {
    return static_cast<int>(2 * std::numbers::pi * radius(ring) / kStride);
  };
  int round = 0;
  for (int ring = 0; ring < count; ++ring) round += steps(ring);
  int left = rings.elapsed % round;
  int ring = 0;
  while (left >= steps(ring)) left -= steps(ring++);
  return {radius(ring), rings.elapsed / round % 2 == 0 ? 1 : -1};
}

// Takes the cube, then leads it low over the table to where `goal` says.
template <class Goal>
void lead_cube(const State& state, int env, int cube, Goal goal, float* action) {
  const Eigen::Vector3d pos = prop_pos(state, env, cube);
  Grip grip{.prop = cube,
            .tool = lean_outwards(tool_for_cube(state, env, cube), pos, kLean),
            .travel_height = kTakeHeight};
  if (!take(state, env, grip, action)) return;
  const double in_hand = state.tcp_pos.row(env)[2] - pos.z();
  grip.travel_height = kTraceHeight;
  grip.tool = lean_outwards(kToolDown, pos, kLean);  // round after round does not wind up the wrist
  const Vec2 at = goal(Vec2(pos.x(), pos.y()));
  carry(state, env, grip, {at.x(), at.y(), kTraceHeight - in_hand}, action);
}

}  // namespace

// A waypoint ahead of the one where the cube is between the last checkpoints and the next one; the
// farther it has strayed from its way, the nearer.
Vec2 next_on_contour(const Contour& contour, int visited, const Vec2& at) {
  constexpr double kAhead = 0.035;   // m along the contour
  constexpr double kStrayed = 0.02;  // m: from there on, back to the way first
  const ContourSet& set = contour.set();
  const int next = set.next_checkpoint(visited);
  if (visited == 0) return contour.checkpoint(next);
  const int last = next > 0 ? set.waypoint_of(next) : set.waypoints();
  const auto waypoint = [&](int index) { return contour.waypoint(index % set.waypoints()); };
  const auto away = [&](int index) { return (waypoint(index) - at).norm(); };
  int aim = last;
  for (int i = std::max(0, last - 2 * set.waypoint_of(1)); i < last; ++i) {
    if (away(i) < away(aim)) aim = i;
  }
  double ahead = kAhead * (1 - away(aim) / kStrayed);
  for (; aim < last && ahead > 0; ++aim) ahead -= (waypoint(aim + 1) - waypoint(aim)).norm();
  return waypoint(aim);
}

void trace_contour(const State& state, int env, int cube, const Contour& contour, int visited,
                   float* action) {
  const auto goal = [&](const Vec2& at) { return next_on_contour(contour, visited, at); };
  lead_cube(state, env, cube, goal, action);
}

void sweep_rings(const State& state, int env, int cube, const SweepRings& rings, float* action) {
  constexpr double kAhead = 0.045;          // m
  constexpr double kMostTurn = 0.6;         // rad
  constexpr double kMostCorrection = 0.01;  // m
  const RingCourse course = ring_course(rings);
  const auto goal = [&](const Vec2& at) -> Vec2 {
    const Vec2 offset = at - rings.center;
    const double angle = real::atan2(offset.y(), offset.x()) +
                         course.turn * std::min(kMostTurn, kAhead / course.radius);
    const double inside =
        std::clamp(course.radius - offset.norm(), -kMostCorrection, kMostCorrection);
    return rings.center + (course.radius + inside) * Vec2(real::cos(angle), real::sin(angle));
  };
  lead_cube(state, env, cube, goal, action);
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
