// Forgetting: success over the delay between cue and question.
#pragma once

#include "protocol/eval/probe/probe_plan.h"

namespace engram {

ProbePlan plan_forgetting(const ProbeTask& task);

}  // namespace engram
