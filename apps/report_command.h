// `engram report`.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_report_command(const Command& program);

}  // namespace engram::apps
