// Plans of probes: the trials that a probe asks for, and what it makes of their results.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/batch/options.h"
#include "core/task/task.h"
#include "protocol/eval/probe/question.h"
#include "protocol/eval/probe/trial.h"
#include "protocol/io/json.h"
#include "tasks/registry.h"

namespace engram {

// A task under probe, with the constants that the user has given.
struct ProbeTask {
  const RegistryEntry* entry = nullptr;
  ConstantTable constants = {};
  TaskInfo info = {};  // with them

  const MemoryFacts& facts() const { return entry->definition->memory; }
  // Why no two of its episodes differ in their past alone; empty: they do.
  std::string no_counterfactuals() const;
  // The user's constants, with these in their place.
  ConstantTable with(const ConstantTable& others) const;
};

ProbeTask probe_task(const RegistryEntry& entry, const ConstantTable& constants);

// Trials with one set of constants: a group for every episode number, of one length.
struct ProbeCondition {
  const RegistryEntry* entry = nullptr;
  ConstantTable constants = {};          // all that are given
  std::optional<Policy> control = {};    // plays in place of the probed policy
  std::string name = {};                 // among all of the task
  const RegistryEntry* other = nullptr;  // task of the episodes between; null: the same
  std::function<TrialGroup(Lookahead&, std::uint64_t seed)> trials = {};
};

// By episode number, then by place in the group.
using ConditionResults = std::vector<std::vector<TrialResult>>;

struct ProbePlan {
  std::vector<ProbeCondition> conditions;
  // results: of the conditions, in their order.
  std::function<Json(const std::vector<ConditionResults>& results)> document;
};

// A plan without trials, which says why.
ProbePlan skipped_plan(const std::string& reason);

// --- shares of results ---

// {rate, interval, n}: a share of trials, n of them, with its 95 % interval (Wilson). together: how
// many neighbours are of one episode number, and so count as one where they are alike.
Json rate_document(const std::vector<bool>& trials, int together = 1);
// The share of the first trial of each group.
Json success_document(const ConditionResults& results);
Json first_answer_document(const ConditionResults& results);

}  // namespace engram
