// How oracles turn the peg.
#pragma once

#include "core/sim/state.h"

namespace engram::tasks {

// The peg lies on the table.
struct PegSize {
  double half_width = 0.025;  // m
  double half_length = 0.12;
};

// What is to be done with the peg, the task's only prop.
struct PegGoal {
  PegSize size;
  double threshold = 0.1;  // rad: error within which it has turned far enough
  double turn = 0;         // still to be turned, rad
  bool wait = false;       // with the peg in the hand
  double x = 0;            // m: where the centre is to be
  double y = 0;
};

// Pushes one end of the peg sideways with the closed fingers until it has turned.
void push_peg(const State& state, int env, const PegGoal& goal, float* action);

// Grasps the peg at its centre and turns the hand.
void twist_peg(const State& state, int env, const PegGoal& goal, float* action);

}  // namespace engram::tasks
