// Capacity: success over how much there is to remember.
#pragma once

#include "protocol/eval/probe/probe_plan.h"

namespace engram {

// fits: whether the probed policy can observe the task with these constants.
ProbePlan plan_capacity(const ProbeTask& task,
                        const std::function<bool(const ConstantTable& constants)>& fits);

}  // namespace engram
