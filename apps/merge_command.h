// `engram merge`: one result of the shards of a run (docs/evaluation.md).
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_merge_command(const Command& program);

}  // namespace engram::apps
