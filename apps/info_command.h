// `engram info`: one task in full.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_info_command(const Command& program);

}  // namespace engram::apps
