// `engram eval`: the evaluation protocol (docs/evaluation.md), with built-in or external policies.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_eval_command(const Command& program);

}  // namespace engram::apps
