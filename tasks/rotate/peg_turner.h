// How oracles turn the peg.
#pragma once

#include "core/physics/state.h"

namespace engram::tasks {

inline constexpr double PEG_HALF_WIDTH = 0.025;  // m
inline constexpr double PEG_HALF_LENGTH = 0.12;

// What is to be done with the peg, the task's only prop.
struct PegGoal {
  double turn = 0;  // still to be turned, rad
  double x = 0;     // m: where the centre is to be
  double y = 0;
};

// Pushes one end of the peg sideways with the closed fingers until it has turned.
void push_peg(const State& state, int env, const PegGoal& goal, float* action);

// Grasps the peg at its centre and turns the hand.
void twist_peg(const State& state, int env, const PegGoal& goal, float* action);

}  // namespace engram::tasks
