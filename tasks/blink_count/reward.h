// The dense reward of BlinkCountButtonPress (docs/tasks/blink_count.md).
#pragma once

#include "tasks/blink_count/params.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

// Everything after the evaluation of the step (tasks/common/reward_dict.h).
struct BlinkReward {
  const BlinkCountParams& params;
  double height = 0;              // of the TCP, m
  double xy_distance = 0;         // to the red button, m
  double cap_distance = 0;        // from the TCP to the red cap, m
  double black_cap_distance = 0;  // and to the black one
  double depth = 0;               // of the red button, m
  double black_depth = 0;
  int press_count = 0;
  int target = 1;
  bool pending = false;     // a press of the red button waits for its lift
  double start_height = 0;  // of that press, m
  PressEvents red = {};     // what happened in this step
  bool submitted = false;
  bool acting = false;
  bool failed = false;
  bool success = false;
  ActionCost action_cost = {};
  // Terms. 1 in its phase, else 0.
  double cue = 0;
  double pressing = 0;    // a press has to begin
  double lifting = 0;     // a press has to end
  double submitting = 0;  // the count is right
  // The red button.
  double reach = 0;
  double press = 0;
  double progress = 0;  // of the count
  double lift_gap = 0;  // m, still to be lifted
  double lift = 0;
  double upright = 0;
  double too_high = 0;
  double hover = 0;
  // The black button.
  double black_reach = 0;
  double black_press = 0;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reach);
    row.term("press_progress_reward", "", press);
    row.term("count_progress", "", progress);
    row.term("new_raw_press_reward", "", red.pressed);
    row.term("new_press_reward", "", red.confirmed);
    row.term("new_release_reward", "", red.released);
    row.term("cue_reach_reward", "", cue * reach);
    row.term("cue_no_press_reward", "", cue * (1 - press));
    row.term("action_phase1", "", pressing);
    row.term("action_phase2", "", lifting);
    row.term("button_reach_reward", "", pressing * reach);
    row.term("button_press_reward", "", pressing * press);
    row.term("action_count_reward", "", pressing * progress);
    row.term("action_new_raw_press_reward", "", pressing * red.pressed);
    row.term("phase2_lift_reward", "", lifting * lift);
    row.term("phase2_vertical_reward", "", lifting * upright);
    row.term("phase2_release_reward", "", lifting * red.released);
    row.term("confirm_cycle_reward", "", lifting * red.confirmed);
    row.term("early_press_penalty", "", cue * press);
    row.term("phase1_lift_penalty", "", too_high);
    row.term("phase1_hover_penalty", "", hover);
    row.term("hold_down_penalty", "", lifting * press);
    row.term("tcp_to_button_dist", "m", cap_distance);
    row.term("tcp_to_confirm_dist", "m", black_cap_distance);
    row.term("xy_dist_to_button", "m", xy_distance);
    row.term("lift_gap", "m", lift_gap);
    row.term("confirm_reaching_reward", "", black_reach);
    row.term("confirm_press_progress_reward", "", black_press);
    row.term("new_confirm_press_reward", "", submitted);
    row.term("submit_phase", "", submitting);
    row.term("press_count", "", press_count);
    row.term("target_blinks", "", target);
    row.term("failed", "", failed);
    smooth.list_terms(row);
  }

 private:
  double weighted_sum() const;
};

}  // namespace engram::tasks
