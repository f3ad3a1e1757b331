// `engram collect`: demonstrations to learn from.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_collect_command(const Command& program);

}  // namespace engram::apps
