// Interference: other episodes between cue and question, in which the policy is not reset.
#pragma once

#include "protocol/eval/probe/probe_plan.h"

namespace engram {

// other: task of the episodes between, instead of the task's own; or null.
ProbePlan plan_interference(const ProbeTask& task, const RegistryEntry* other);

}  // namespace engram
