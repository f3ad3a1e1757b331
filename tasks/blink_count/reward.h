// The dense reward of BlinkCountButtonPress (docs/tasks/blink_count.md).
#pragma once

#include "tasks/blink_count/params.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/press_button.h"

namespace engram::tasks {

// Everything after the evaluation of the step.
struct BlinkRewardInputs {
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
  PressEvents red;          // what happened in this step
  bool submitted = false;
  bool acting = false;
  bool failed = false;
  bool success = false;
  ActionCost action_cost;
};

struct BlinkRewardTerms {
  // 1 in its phase, else 0.
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
  SmoothnessTerms smooth;
  double reward = 0;
};

BlinkRewardTerms blink_reward(const BlinkRewardInputs& inputs, const BlinkCountParams& params);

// The terms of info "reward_dict", name beside value.
template <class Visitor>
void list_blink_terms(Visitor& row, const BlinkRewardInputs& in, const BlinkRewardTerms& terms) {
  row.term("reaching_reward", "", terms.reach);
  row.term("press_progress_reward", "", terms.press);
  row.term("count_progress", "", terms.progress);
  row.term("new_raw_press_reward", "", in.red.pressed);
  row.term("new_press_reward", "", in.red.confirmed);
  row.term("new_release_reward", "", in.red.released);
  row.term("cue_reach_reward", "", terms.cue * terms.reach);
  row.term("cue_no_press_reward", "", terms.cue * (1 - terms.press));
  row.term("action_phase1", "", terms.pressing);
  row.term("action_phase2", "", terms.lifting);
  row.term("button_reach_reward", "", terms.pressing * terms.reach);
  row.term("button_press_reward", "", terms.pressing * terms.press);
  row.term("action_count_reward", "", terms.pressing * terms.progress);
  row.term("action_new_raw_press_reward", "", terms.pressing * in.red.pressed);
  row.term("phase2_lift_reward", "", terms.lifting * terms.lift);
  row.term("phase2_vertical_reward", "", terms.lifting * terms.upright);
  row.term("phase2_release_reward", "", terms.lifting * in.red.released);
  row.term("confirm_cycle_reward", "", terms.lifting * in.red.confirmed);
  row.term("early_press_penalty", "", terms.cue * terms.press);
  row.term("phase1_lift_penalty", "", terms.too_high);
  row.term("phase1_hover_penalty", "", terms.hover);
  row.term("hold_down_penalty", "", terms.lifting * terms.press);
  row.term("tcp_to_button_dist", "m", in.cap_distance);
  row.term("tcp_to_confirm_dist", "m", in.black_cap_distance);
  row.term("xy_dist_to_button", "m", in.xy_distance);
  row.term("lift_gap", "m", terms.lift_gap);
  row.term("confirm_reaching_reward", "", terms.black_reach);
  row.term("confirm_press_progress_reward", "", terms.black_press);
  row.term("new_confirm_press_reward", "", in.submitted);
  row.term("submit_phase", "", terms.submitting);
  row.term("press_count", "", in.press_count);
  row.term("target_blinks", "", in.target);
  row.term("failed", "", in.failed);
  row.term("action_l2", "", terms.smooth.action_l2);
  row.term("delta_action_l2", "", terms.smooth.action_delta_l2);
  row.term("qvel_l2", "", terms.smooth.qvel_l2);
  row.term("smooth_penalty", "", terms.smooth.penalty);
}

}  // namespace engram::tasks
