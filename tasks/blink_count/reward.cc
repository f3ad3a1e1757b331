#include "tasks/blink_count/reward.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace engram::tasks {

// Upstream's terms, those that are always zero included: everything is multiplied by the action
// phase, and a press that begins or ends changes the sub-phase in the same evaluation.
BlinkReward blink_reward(const BlinkRewardInputs& in, const PressButtonParams& button) {
  const auto flag = [](bool value) { return value ? 1.0 : 0.0; };
  const auto near = [](double distance) { return 1 - std::tanh(8 * distance); };
  const auto share = [](double value) { return std::clamp(value, 0.0, 1.0); };

  const double acting = flag(in.acting);
  const double cue = 1 - acting;
  const double pressing = acting * flag(!in.pending);  // to begin a press
  const double lifting = acting * flag(in.pending);    // to end it
  const double submitting = acting * flag(in.press_count == in.target);

  const double reach = near(in.cap_distance);
  const double black_reach = near(in.black_cap_distance);
  const double press = share(in.depth / button.BUTTON_CAP_TRAVEL);
  const double black_press = share(in.black_depth / button.BUTTON_CAP_TRAVEL);
  const double progress =
      1 - share(std::abs(in.target - in.press_count) / std::max<double>(in.target, 1));
  const double lift_gap = std::max(in.start_height + button.REQUIRED_LIFT_HEIGHT - in.height, 0.0);
  const double lift = 1 - std::tanh(4 * lift_gap);
  const double upright = near(in.xy_distance);
  const double above = std::max(in.height - button.shape.top_height(), 0.0);
  const double too_high = pressing * share((above - 0.20) / 0.1);
  const double hover = pressing * share((above - 0.06) / 0.1);
  const SmoothnessTerms smooth = smoothness(in.haste, kBlinkSmoothness);

  const double began = flag(in.red.pressed);
  const double released = flag(in.red.released);
  const double confirmed = flag(in.red.confirmed);
  const double submitted = flag(in.submitted);

  double sum = 0.25 * reach * acting;
  sum += cue * (0.75 * reach + 0.75 * (1 - press) - 1.5 * press);
  sum += pressing * (1.5 * reach + 2.0 * press + 1.0 * progress + 4.0 * began);
  sum += lifting * (5.0 * lift + 2.0 * upright + 2.0 * released + 6.0 * confirmed - 2.0 * press);
  sum += submitting * (1.5 * black_reach + 2.0 * black_press) + 10.0 * submitted;
  sum -= 1.5 * too_high + 3.0 * hover + smooth.penalty;

  BlinkReward result;
  result.reward = acting * sum - FAILURE_PENALTY * flag(in.failed);
  if (in.success) result.reward = SUCCESS_BONUS;
  result.terms = {reach,
                  press,
                  progress,
                  began,
                  confirmed,
                  released,
                  cue * reach,
                  cue * (1 - press),
                  pressing,
                  lifting,
                  pressing * reach,
                  pressing * press,
                  pressing * progress,
                  pressing * began,
                  lifting * lift,
                  lifting * upright,
                  lifting * released,
                  lifting * confirmed,
                  cue * press,
                  too_high,
                  hover,
                  lifting * press,
                  in.cap_distance,
                  in.black_cap_distance,
                  in.xy_distance,
                  lift_gap,
                  black_reach,
                  black_press,
                  submitted,
                  submitting,
                  static_cast<double>(in.press_count),
                  static_cast<double>(in.target),
                  flag(in.failed),
                  smooth.action_l2,
                  smooth.action_delta_l2,
                  smooth.qvel_l2,
                  smooth.penalty};
  return result;
}

std::vector<std::string> blink_reward_term_names() {
  return {"reaching_reward",
          "press_progress_reward",
          "count_progress",
          "new_raw_press_reward",
          "new_press_reward",
          "new_release_reward",
          "cue_reach_reward",
          "cue_no_press_reward",
          "action_phase1",
          "action_phase2",
          "button_reach_reward",
          "button_press_reward",
          "action_count_reward",
          "action_new_raw_press_reward",
          "phase2_lift_reward",
          "phase2_vertical_reward",
          "phase2_release_reward",
          "confirm_cycle_reward",
          "early_press_penalty",
          "phase1_lift_penalty",
          "phase1_hover_penalty",
          "hold_down_penalty",
          "tcp_to_button_dist",
          "tcp_to_confirm_dist",
          "xy_dist_to_button",
          "lift_gap",
          "confirm_reaching_reward",
          "confirm_press_progress_reward",
          "new_confirm_press_reward",
          "submit_phase",
          "press_count",
          "target_blinks",
          "failed",
          "action_l2",
          "delta_action_l2",
          "qvel_l2",
          "smooth_penalty"};
}

}  // namespace engram::tasks
