// `engram doctor`: what this build and this machine offer.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_doctor_command(const Command& program);

}  // namespace engram::apps
