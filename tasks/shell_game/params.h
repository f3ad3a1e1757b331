// What all shell games are made of, named as the class constants.
#pragma once

#include <string>

#include "mjcf/mug.h"
#include "tasks/common/changes.h"
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

  // How many times as large as the benchmark's the mugs are.
  double mug_ratio() const { return MUG_SCALE / mjcf::kMugScale; }
  // Height of the origin of a mug that stands, m.
  double resting_height() const { return mjcf::kMugRestingHeight * mug_ratio(); }
  // By how much mugs are higher than the benchmark's, m.
  double extra_height() const { return 2 * (resting_height() - mjcf::kMugRestingHeight); }
  // How near to the goal's centre a mug has to be that is moved there, m.
  double placed_distance() const { return 1.6 * GOAL_THRESH; }

  void constants(Changes& list);
};

// Of the games in which a mug is touched.
struct TouchParams : ShellGameParams {
  // Height of the TCP above the origin of a mug that the oracle touches, m.
  double touch_gap() const;

  void check(int horizon) const;
  // The same for a game that goes on with other phases after the cue.
  void check_touch() const;
};

}  // namespace engram::tasks
