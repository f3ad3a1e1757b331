// engram verify: the same seeds give the same bits, however a batch is run.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_verify_command(const Command& program);

}  // namespace engram::apps
