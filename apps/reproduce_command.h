// `engram reproduce`.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_reproduce_command(const Command& program);

}  // namespace engram::apps
