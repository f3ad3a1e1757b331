// `engram soak`: long runs that watch for growth, drift and instability.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_soak_command(const Command& program);

}  // namespace engram::apps
