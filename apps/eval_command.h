// `engram eval`: the evaluation protocol (docs/evaluation.md), with built-in or external policies.
#pragma once

#include "apps/command_line.h"
#include "protocol/eval/evaluation_run.h"

namespace engram::apps {

// Prints the results of a run that is finished, and where they are.
void print_results(const EvaluationRun& run, bool json);

void add_eval_command(const Command& program);

}  // namespace engram::apps
