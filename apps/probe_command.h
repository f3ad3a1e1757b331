// `engram probe`: does a policy read its memory?
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_probe_command(const Command& program);

}  // namespace engram::apps
