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

}  // namespace

// Upstream's sum, those parts that are always zero included: everything is multiplied by the
// action phase, and a press that begins or ends changes the sub-phase in the same evaluation.
double BlinkReward::weighted_sum() const {
  const double active = flag(acting);
  const double began = flag(red.pressed);
  const double released = flag(red.released);
  const double confirmed = flag(red.confirmed);

  double sum = 0.25 * reach * active;
  sum += cue * (0.75 * reach + 0.75 * (1 - press) - 1.5 * press);
  sum += pressing * (1.5 * reach + 2.0 * press + 1.0 * progress + 4.0 * began);
  sum += lifting * (5.0 * lift + 2.0 * upright + 2.0 * released + 6.0 * confirmed - 2.0 * press);
  sum += submitting * (1.5 * black_reach + 2.0 * black_press) + 10.0 * flag(submitted);
  sum -= 1.5 * too_high + 3.0 * hover + smooth.penalty;
  return active * sum - FAILURE_PENALTY * flag(failed);
}

double BlinkReward::compute() {
  const PressButtonParams& button = params.button;
  const double active = flag(acting);
  cue = 1 - active;
  pressing = active * flag(!pending);
  lifting = active * flag(pending);
  submitting = active * flag(press_count == target);

  reach = near(cap_distance);
  press = share(depth / button.BUTTON_CAP_TRAVEL);
  progress = 1 - share(std::abs(target - press_count) / std::max<double>(target, 1));
  lift_gap = std::max(start_height + button.REQUIRED_LIFT_HEIGHT - height, 0.0);
  lift = 1 - real::tanh(4 * lift_gap);
  upright = near(xy_distance);
  const double above = std::max(height - button.shape.top_height(), 0.0);
  too_high = pressing * share((above - 0.20) / 0.1);
  hover = pressing * share((above - 0.06) / 0.1);

  black_reach = near(black_cap_distance);
  black_press = share(black_depth / button.BUTTON_CAP_TRAVEL);
  smooth = tasks::smoothness(action_cost, params.smoothness);
  return success ? SUCCESS_BONUS : weighted_sum();
}

}  // namespace engram::tasks
