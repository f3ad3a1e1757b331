#include "tasks/trace_shape/oracle.h"

#include "tasks/parts/grasp_servo.h"

namespace engram::tasks {
namespace {

constexpr double kTakeHeight = 0.12;   // m, of the TCP on the way to the cube
constexpr double kTraceHeight = 0.06;  // m, of the TCP while it carries the cube

// The red cube may have pushed the green one where a vertical tool cannot follow.
constexpr Lean kLean{.fold = 0.33};

}  // namespace

void trace_contour(const State& state, int env, int cube, const Contour& contour, int visited,
                   float* action) {
  const Eigen::Map<const Eigen::Vector3d> pos(state.prop_pos_of(env, cube));
  Grip grip{.prop = cube,
            .tool = lean_outwards(tool_for_cube(state, env, cube), pos, kLean),
            .travel_height = kTakeHeight};
  if (!take(state, env, grip, action)) return;
  const double in_hand = state.tcp_pos.row(env)[2] - pos.z();
  grip.travel_height = kTraceHeight;
  const Vec2 goal = contour.checkpoint(next_checkpoint(visited));
  carry(state, env, grip, {goal.x(), goal.y(), kTraceHeight - in_hand}, action);
}

void await_demo(float* action) { hold_tool(kGripperOpen, action); }

}  // namespace engram::tasks
