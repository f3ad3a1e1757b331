// The phase between cue and manipulation in which mugs swap places. They stand where they are put
// in every control step: in between, physics may move them, so that the robot feels what it meets,
// but it cannot carry anything away.
#pragma once

#include "tasks/common/random_variables.h"
#include "tasks/common/task_options.h"
#include "tasks/shell_game/mugs.h"
#include "tasks/shell_game/swaps.h"
#include "tasks/shell_game/touch_params.h"

namespace engram::tasks {

// One row of a family's table.
struct ShuffleParams : TouchParams {
  StepRange SHUFFLE_PHASE_STEPS;
  StepRange NUM_SWAPS;
  bool frozen = false;            // the canonical wrapper zeroes actions before the manipulation
  double SWAP_ARC_HEIGHT = 0.06;  // m

  // The value of elapsed at which the shuffle is over at the latest.
  int latest_end() const { return CUE_PHASE_STEPS.high + SHUFFLE_PHASE_STEPS.high; }

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

class ShufflePhase {
 public:
  static constexpr int kMaxSwaps = 40;

  ShufflePhase(const ShuffleParams& params, RandomVariables list);

  // Adds phases and the option of steps that are left over after the last swap.
  void describe(TaskInfo& info);
  void bind(const Bindings& bindings);
  // Draws a shuffle that begins at elapsed = begin.
  void reset(const Episode& episode, int begin) const;

  bool begins(int env) const { return state_->elapsed[env] == swaps_.begin(env); }
  int end(int env) const { return swaps_.end(env); }
  int final_slot(int env, int mug) const { return swaps_.final_slot(env, mug); }
  // Stands the mugs where they are in this step.
  void move(const Mugs& mugs, int env) const;

 private:
  ShuffleParams params_;
  IntegerVariable steps_;
  IntegerVariable num_swaps_;
  VariableHandle pairs_;
  TaskOption snap_back_;
  const State* state_ = nullptr;
  Swaps swaps_;
};

}  // namespace engram::tasks
