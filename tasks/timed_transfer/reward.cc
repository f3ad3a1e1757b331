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

double TransferReward::compute() {
  reaching = 1 - real::tanh(10 * tcp_to_cube);
  place = 1 - real::tanh(5 * cube_to_goal);
  stillness = 1 - real::tanh(5 * action_cost.arm_speed);
  smooth = tasks::smoothness(action_cost, smoothness);
  if (failed) return -FAILURE_PENALTY;
  if (success) return kTimedTransferSuccessReward;
  if (!count.signal_on) return 0;
  double reward = 2 * reaching + (grasped ? 3 : 0) - smooth.penalty;
  if (grasped && count.in_window) reward += 20 * place;
  if (on_red && count.in_window) reward += 5 + 3 * stillness;
  if (on_red && count.before_window) reward -= 5;
  return reward;
}

}  // namespace engram::tasks
