// Parameters of all shell games, named as the class constants.
#pragma once

#include <string>

#include "mjcf/mug.h"
#include "tasks/common/constant_binder.h"
#include "tasks/family.h"

namespace engram::tasks {

inline constexpr int kCups = 3;                // slots 0 left (-y), 1 center, 2 right
inline constexpr double HEIGHT_OFFSET = 1000;  // m, added to the height of what is hidden

// One row of a family's table.
struct ShellGameParams {
  TaskRow task;
  double GOAL_THRESH = 0.08;  // m
  StepRange CUE_PHASE_STEPS{1, 5};
  double MIN_DIST = 0.2;      // m, from slot to slot along y
  double BALL_RADIUS = 0.02;  // m
  double MUG_SCALE = mjcf::kMugScale;

  // Size of the mugs, as a multiple of the benchmark's.
  double mug_ratio() const { return MUG_SCALE / mjcf::kMugScale; }
  // Height of the origin of a mug that stands, m.
  double resting_height() const { return mjcf::kMugRestingHeight * mug_ratio(); }
  // Height of the mugs beyond the benchmark's, m.
  double extra_height() const { return 2 * (resting_height() - mjcf::kMugRestingHeight); }
  // Distance from the goal's centre within which a mug that is moved there has to be, m.
  double placed_distance() const { return 1.6 * GOAL_THRESH; }

  void declare(ConstantBinder& constants);
};

}  // namespace engram::tasks
