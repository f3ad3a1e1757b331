// `engram rollout`: batched rollouts and their speed.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_rollout_command(const Command& program);

}  // namespace engram::apps
