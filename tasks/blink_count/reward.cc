#include "tasks/blink_count/reward.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

double flag(bool value) { return value ? 1.0 : 0.0; }
double near(double distance) { return 1 - real::tanh(8 * distance); }
double share(double value) { return std::clamp(value, 0.0, 1.0); }

// Upstream's sum, those parts that are always zero included: everything is multiplied by the
// action phase, and a press that begins or ends changes the sub-phase in the same evaluation.
double weighted_sum(const BlinkRewardInputs& in, const BlinkRewardTerms& terms) {
  const double acting = flag(in.acting);
  const double began = flag(in.red.pressed);
  const double released = flag(in.red.released);
  const double confirmed = flag(in.red.confirmed);

  double sum = 0.25 * terms.reach * acting;
  sum += terms.cue * (0.75 * terms.reach + 0.75 * (1 - terms.press) - 1.5 * terms.press);
  sum +=
      terms.pressing * (1.5 * terms.reach + 2.0 * terms.press + 1.0 * terms.progress + 4.0 * began);
  sum += terms.lifting * (5.0 * terms.lift + 2.0 * terms.upright + 2.0 * released +
                          6.0 * confirmed - 2.0 * terms.press);
  sum += terms.submitting * (1.5 * terms.black_reach + 2.0 * terms.black_press) +
         10.0 * flag(in.submitted);
  sum -= 1.5 * terms.too_high + 3.0 * terms.hover + terms.smooth.penalty;
  return acting * sum - FAILURE_PENALTY * flag(in.failed);
}

}  // namespace

BlinkRewardTerms blink_reward(const BlinkRewardInputs& in, const BlinkCountParams& params) {
  const PressButtonParams& button = params.button;
  BlinkRewardTerms terms;
  const double acting = flag(in.acting);
  terms.cue = 1 - acting;
  terms.pressing = acting * flag(!in.pending);
  terms.lifting = acting * flag(in.pending);
  terms.submitting = acting * flag(in.press_count == in.target);

  terms.reach = near(in.cap_distance);
  terms.press = share(in.depth / button.BUTTON_CAP_TRAVEL);
  terms.progress = 1 - share(std::abs(in.target - in.press_count) / std::max<double>(in.target, 1));
  terms.lift_gap = std::max(in.start_height + button.REQUIRED_LIFT_HEIGHT - in.height, 0.0);
  terms.lift = 1 - real::tanh(4 * terms.lift_gap);
  terms.upright = near(in.xy_distance);
  const double above = std::max(in.height - button.shape.top_height(), 0.0);
  terms.too_high = terms.pressing * share((above - 0.20) / 0.1);
  terms.hover = terms.pressing * share((above - 0.06) / 0.1);

  terms.black_reach = near(in.black_cap_distance);
  terms.black_press = share(in.black_depth / button.BUTTON_CAP_TRAVEL);
  terms.smooth = smoothness(in.action_cost, params.smoothness);
  terms.reward = in.success ? SUCCESS_BONUS : weighted_sum(in, terms);
  return terms;
}

}  // namespace engram::tasks
