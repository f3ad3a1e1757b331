// Control steps that the phases of an episode take of its horizon.
#pragma once

#include <initializer_list>

#include "tasks/common/constant_binder.h"

namespace engram::tasks {

// Lengths that users may choose for a phase, control steps.
inline constexpr Bounds kPhaseSteps{1, 100'000};

// Greatest length of a phase, and the constant that says so.
struct PhaseBudget {
  const char* name;
  int steps;
};

// Throws Error (kInvalidArgument), with the sum, unless the horizon leaves that many control steps
// to act.
void check_horizon(int horizon, std::initializer_list<PhaseBudget> phases, int min_to_act);

}  // namespace engram::tasks
