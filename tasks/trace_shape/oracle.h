// How the oracles of TraceShape and TraceShapeSeq trace a contour: take the green cube and carry it
// low over the table, from one checkpoint to the next.
#pragma once

#include "core/env/task.h"
#include "tasks/common/press_button.h"
#include "tasks/trace_shape/contour.h"

namespace engram::tasks {

// The tracing of an agent that goes by a guess: what it believes to have visited.
struct GuessedTrace {
  Column<std::int32_t> element;
  Column<std::int32_t> visited;

  void bind(ColumnStore& memory, const ContourSet& set) {
    element = memory.add<std::int32_t>("guess_element");
    visited = memory.add<std::int32_t>("guess_visited");
    memory.limit("guess_visited", 0, set.all_visited());
  }
};

// Where to steer for from `at`: along the contour to the first checkpoint that was not visited, or
// back to the start.
Vec2 next_on_contour(const Contour& contour, int visited, const Vec2& at);

// Writes the next action of taking the cube there.
void trace_contour(const State& state, int env, int cube, const Contour& contour, int visited,
                   float* action);

// Rings about a point that pass near every place where a contour may lead.
struct SweepRings {
  Vec2 center;
  double least = 0;  // m from the centre
  double most = 0;
  double reach = 0;  // m to either side of a ring
  int elapsed = 0;   // control steps: which ring it is
};

// Writes the next action of leading the cube around them, one after the other and then again.
void sweep_rings(const State& state, int env, int cube, const SweepRings& rings, float* action);

// Lets the cube go, then presses the button where it is nearest to the robot.
void submit_trace(const State& state, int env, int cube, const PressButton& button, float* action);

// The action while there is nothing to do yet: the tool stays, as wide open as the cube.
void await_demo(float* action);

}  // namespace engram::tasks
