// How oracles catch the rolling ball: meet it, run along above it, come down over it and close the
// fingers, one before and one behind it.
#pragma once

#include "tasks/intercept/ball_launch.h"

namespace engram::tasks {

// `radius`: of the ball, m.

// True while the closed fingers have the ball between them.
bool holds_ball(const State& state, int env, double radius);

// Writes the next action towards a catch; it keeps the ball once it is held, moving on with it.
void catch_ball(const State& state, int env, double radius, float* action);

}  // namespace engram::tasks
