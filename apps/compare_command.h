// `engram compare`.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_compare_command(const Command& program);

}  // namespace engram::apps
