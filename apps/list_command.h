// `engram list`: the registry.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_list_command(const Command& program);

}  // namespace engram::apps
