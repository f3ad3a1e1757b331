#include "protocol/eval/probe/probe_plan.h"

#include <algorithm>

#include "core/base/error.h"
#include "protocol/eval/probe/counterfactual.h"
#include "protocol/eval/results/statistics.h"
#include "protocol/eval/run/mean.h"

namespace engram {
namespace {

template <class Of>
Json first_trials(const ConditionResults& results, Of&& of) {
  std::vector<bool> values;
  for (const std::vector<TrialResult>& group : results) {
    if (group.front().played != 0) values.push_back(of(group.front()));
  }
  return rate_document(values);
}

// Families outside of the tree may be wrong about their constants and draws.
void require_known(const ProbeTask& task, std::string_view name, const char* fact, bool or_draw) {
  const TaskInfo& info = task.info;
  const bool constant =
      std::ranges::find(info.constants, name, &TaskConstant::name) != info.constants.end();
  const bool draw =
      or_draw && std::ranges::find(info.random_variables, name, &RandomVariable::name) !=
                     info.random_variables.end();
  if (name.empty() || constant || draw) return;
  throw Error(Error::kInvalidArgument, "MemoryFacts::" + std::string(fact) + " of " + info.family +
                                           ": '" + std::string(name) +
                                           "' given, the name of a constant" +
                                           (or_draw ? " or a draw" : "") + " needed");
}

}  // namespace

std::string ProbeTask::no_counterfactuals() const {
  if (!facts().no_counterfactuals.empty()) return std::string(facts().no_counterfactuals);
  if (hidden_draw(facts(), info).empty()) return "the task names no hidden draw";
  if (info.answer.empty()) return "the task defines no answer";
  return {};
}

ConstantTable ProbeTask::with(const ConstantTable& others) const {
  return merge_constants(constants, others);
}

ProbeTask probe_task(const RegistryEntry& entry, const ConstantTable& constants) {
  ProbeTask task{&entry, constants, make_task(entry.id, constants)->info()};
  const MemoryFacts& facts = task.facts();
  require_known(task, facts.delay, "delay", false);
  require_known(task, facts.items, "items", true);
  if (facts.cue_by_hand) {
    task.constants = task.with({{kHorizonConstant, 2 * task.info.horizon}});
    task.info = make_task(entry.id, task.constants)->info();
  }
  return task;
}

ProbePlan skipped_plan(const std::string& reason) {
  return {{}, [reason](const std::vector<ConditionResults>&) {
            return Json(JsonTable{{"skipped", reason}});
          }};
}

// Neighbours are rounds of one episode to effective_episodes, which has them one round after the
// other.
Json rate_document(const std::vector<bool>& trials, int together) {
  const auto step = static_cast<std::size_t>(together);
  std::vector<bool> rounds;
  for (std::size_t round = 0; round < step; ++round) {
    for (std::size_t i = round; i < trials.size(); i += step) rounds.push_back(trials[i]);
  }
  const double rate = trials.empty() ? 0 : mean(trials);
  const Interval interval = wilson_interval(rate, effective_episodes(rounds, together));
  return JsonTable{{"rate", trials.empty() ? Json() : Json(rate)},
                   {"interval", JsonList{interval.low, interval.high}},
                   {"n", trials.size()}};
}

Json success_document(const ConditionResults& results) {
  return first_trials(results, [](const TrialResult& trial) { return trial.success != 0; });
}

Json first_answer_document(const ConditionResults& results) {
  return first_trials(results, [](const TrialResult& trial) { return trial.correct != 0; });
}

}  // namespace engram
