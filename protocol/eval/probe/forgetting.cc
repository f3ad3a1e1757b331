#include "protocol/eval/probe/forgetting.h"

#include <algorithm>

#include "protocol/eval/probe/counterfactual.h"
#include "protocol/eval/probe/half_length.h"

namespace engram {
namespace {

// Delays in which the robot is held, of tasks without a delay of their own, control steps.
constexpr int kHeldDelays[] = {0, 5, 15, 50, 150};
// Delays as multiples of the task's longest one.
constexpr int kTimes[] = {1, 2, 5, 10};

struct Delays {
  std::vector<int> steps;
  int longest = 0;  // of the task itself
};

Delays delays_of(const ProbeTask& task) {
  if (task.facts().delay.empty()) return {{std::begin(kHeldDelays), std::end(kHeldDelays)}, 0};
  const auto constant =
      std::ranges::find(task.info.constants, task.facts().delay, &TaskConstant::name);
  const JsonList& range = list(constant->value);
  Delays delays{{static_cast<int>(number(range.at(0)))}, static_cast<int>(number(range.at(1)))};
  for (const int times : kTimes) delays.steps.push_back(times * delays.longest);
  delays.steps.erase(std::unique(delays.steps.begin(), delays.steps.end()), delays.steps.end());
  return delays;
}

ProbeCondition with_delay(const ProbeTask& task, const Delays& delays, int steps) {
  const bool held = task.facts().delay.empty();
  ConstantTable changed{
      {kHorizonConstant, task.info.horizon + std::max(0, steps - delays.longest)}};
  if (!held) changed.emplace_back(task.facts().delay, JsonList{steps, steps});
  ProbeCondition condition{.entry = task.entry, .constants = task.with(changed)};
  condition.trials = [held, steps](Lookahead& lookahead, std::uint64_t seed) {
    Trial trial{.draw = {seed, {}}};
    if (held) {
      const int end = lookahead.cue_end(trial.draw);
      trial.question = end < 0 ? end : end + steps;
    }
    return TrialGroup{trial};
  };
  return condition;
}

Json document_of(const ProbeTask& task, const std::vector<int>& delays,
                 const std::vector<ConditionResults>& results) {
  JsonList points;
  std::vector<DelayedAnswers> answers;
  for (std::size_t i = 0; i < delays.size(); ++i) {
    points.emplace_back(JsonTable{{"delay", delays[i]},
                                  {"success", success_document(results[i])},
                                  {"first_answer", first_answer_document(results[i])}});
    DelayedAnswers& own = answers.emplace_back(DelayedAnswers{delays[i], {}, {}});
    for (const std::vector<TrialResult>& group : results[i]) {
      own.right.push_back(group.front().correct != 0);
      own.played.push_back(group.front().played != 0);
    }
  }
  const std::string_view constant = task.facts().delay;
  return JsonTable{{"constant", constant.empty() ? Json() : Json(constant)},
                   {"chance", task.info.chance()},
                   {"answer_chance", task.info.answer_chance()},
                   {"points", points},
                   {"half_length", half_length_document(answers, task.info.answer_chance())}};
}

}  // namespace

ProbePlan plan_forgetting(const ProbeTask& task) {
  if (const std::string reason = task.no_counterfactuals(); !reason.empty())
    return skipped_plan(reason);
  const Delays delays = delays_of(task);
  ProbePlan plan;
  for (const int steps : delays.steps) plan.conditions.push_back(with_delay(task, delays, steps));
  plan.document = [task, steps = delays.steps](const std::vector<ConditionResults>& results) {
    return document_of(task, steps, results);
  };
  return plan;
}

}  // namespace engram
