// Expert of the shell games in which a mug is touched: goes over the mug, then down until it is
// touched.
#pragma once

#include "tasks/shell_game/expert.h"
#include "tasks/shell_game/touch_params.h"

namespace engram::tasks {

class TouchExpert final : public ShellGameExpert {
 public:
  // `latest_start`: elapsed at which the manipulation phase begins at the latest.
  TouchExpert(const ShellGame& game, const TouchParams& params, int latest_start)
      : ShellGameExpert(game),
        goal_thresh_(params.GOAL_THRESH),
        touch_gap_(params.touch_gap()),
        latest_start_(latest_start) {}

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  void touch(int env, int slot, double gripper, float* action) const;
  void sweep(int env, double gripper, float* action) const;

  double goal_thresh_;  // m
  double touch_gap_;    // m
  int latest_start_;    // control steps
};

}  // namespace engram::tasks
