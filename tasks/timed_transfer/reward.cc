#include "tasks/timed_transfer/reward.h"

#include "core/math/real_functions.h"

namespace engram::tasks {

TimeWindow time_window(int signal_step, int delay_steps, double tolerance,
                       WindowRounding rounding) {
  if (rounding == WindowRounding::kDown) {
    return {signal_step + static_cast<int>(delay_steps * (1 - tolerance)),
            signal_step + static_cast<int>(delay_steps * (1 + tolerance))};
  }
  constexpr double kHair = 1e-9;  // 0.29 of 100 steps is 28.999999999999996
  const int slack = static_cast<int>(delay_steps * tolerance + kHair);
  return {signal_step + delay_steps - slack, signal_step + delay_steps + slack};
}

CountPhase count_phase(int elapsed, int signal_step, const TimeWindow& window) {
  CountPhase phase;
  phase.signal_on = elapsed >= signal_step;
  phase.before_window = phase.signal_on && elapsed < window.start;
  phase.in_window = elapsed >= window.start && elapsed <= window.end;
  phase.past_window = elapsed > window.end;
  return phase;
}

TransferRewardTerms transfer_reward(const TransferRewardInputs& in) {
  TransferRewardTerms terms;
  terms.reaching = 1 - real::tanh(10 * in.tcp_to_cube);
  terms.place = 1 - real::tanh(5 * in.cube_to_goal);
  terms.stillness = 1 - real::tanh(5 * in.action_cost.arm_speed);
  terms.smooth = smoothness(in.action_cost, in.smoothness);
  if (in.count.signal_on) {
    terms.reward = 2 * terms.reaching + (in.grasped ? 3 : 0) - terms.smooth.penalty;
    if (in.grasped && in.count.in_window) terms.reward += 20 * terms.place;
    if (in.on_red && in.count.in_window) terms.reward += 5 + 3 * terms.stillness;
    if (in.on_red && in.count.before_window) terms.reward -= 5;
  }
  if (in.success) terms.reward = kTimedTransferSuccessReward;
  if (in.failed) terms.reward = -FAILURE_PENALTY;
  return terms;
}

}  // namespace engram::tasks
