#include "tasks/colors/reward.h"

#include <algorithm>

#include "core/base/index.h"
#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

bool contains(std::span<const std::int32_t> targets, int color) {
  return std::find(targets.begin(), targets.end(), color) != targets.end();
}

// Counts places of the cue, not just those before the first mistake; the next target stays at the
// first mismatch for good.
void judge_order(std::span<const std::int32_t> targets, const std::int32_t* order,
                 TouchTally& tally) {
  tally.correct = tally.wrong = 0;
  tally.next = -1;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const bool match = order[i] == targets[i];
    tally.correct += match ? 1 : 0;
    tally.wrong += !match && order[i] != -1 ? 1 : 0;
    if (!match && tally.next < 0) tally.next = targets[i];
  }
  tally.order_ok = tally.next < 0;
}

// Judges the touches so far only; after a mistake there is no next target.
void judge_filled_order(std::span<const std::int32_t> targets, const std::int32_t* order,
                        TouchTally& tally) {
  tally.next = -1;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    if (order[i] == -1) {
      tally.next = targets[i];
      return;
    }
    if (order[i] == targets[i]) continue;
    tally.order_ok = false;
    return;
  }
}

// The next target of the families without an order: Bunch names the lowest colour, Seq follows the
// cue.
int first_untouched(ColorRule rule, std::span<const std::int32_t> targets,
                    std::span<const std::uint8_t> touched) {
  int next = -1;
  for (const std::int32_t color : targets) {
    if (touched[at(color)] != 0) continue;
    if (rule == ColorRule::kSeq) return color;
    if (next < 0 || color < next) next = color;
  }
  return next;
}

}  // namespace

TouchTally tally_touches(ColorRule rule, std::span<const std::int32_t> targets,
                         std::span<const std::uint8_t> touched, const std::int32_t* order) {
  TouchTally tally;
  for (std::size_t color = 0; color < touched.size(); ++color) {
    if (touched[color] == 0) continue;
    ++tally.touched;
    ++(contains(targets, static_cast<int>(color)) ? tally.correct : tally.wrong);
  }
  tally.no_extra = tally.wrong == 0;
  tally.all_touched = tally.no_extra && tally.correct == static_cast<int>(targets.size());
  if (rule == ColorRule::kChain) {
    judge_order(targets, order, tally);
  } else if (rule == ColorRule::kSeqStrict) {
    judge_filled_order(targets, order, tally);
  } else {
    tally.next = first_untouched(rule, targets, touched);
  }
  tally.mistaken = tally.wrong > 0 || (rule == ColorRule::kSeqStrict && !tally.order_ok);
  return tally;
}

int answer_number(const std::int32_t* order, int length) {
  int number = 0;
  for (int i = 0; i < length && order[i] >= 0; ++i) number = 10 * number + order[i] + 1;
  return number;
}

double ColorTouchReward::compute() {
  reaching = 1 - real::tanh(10 * goal_distance);
  const double stillness = 1 - real::tanh(5 * arm_speed);
  sum = reaching + 0.5 * stillness + 90.0 * tally.correct / length - 10.0 * tally.wrong;
  if (success) return kColorTouchSuccessReward;
  return acting ? sum : 0;
}

double ColorReward::compute() {
  touches.compute();
  smooth = tasks::smoothness(action_cost, smoothness);
  displacement_penalty = CUBE_DISPLACEMENT_PENALTY_COEF * mean_displacement;
  if (touches.success) return kColorSuccessReward;
  return touches.acting ? touches.sum - smooth.penalty - displacement_penalty : 0;
}

}  // namespace engram::tasks
