// Twins: two episodes of one present and two pasts. Does the answer follow the past?
#pragma once

#include "protocol/eval/probe/probe_plan.h"

namespace engram {

ProbePlan plan_twins(const ProbeTask& task);

}  // namespace engram
