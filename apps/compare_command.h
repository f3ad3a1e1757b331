// `engram compare`.
#pragma once

#include <string>

#include "apps/command_line.h"
#include "protocol/io/json.h"

namespace engram::apps {

// A line: numbers of episodes with equal digests, in the total of a comparison.
std::string alike_text(const Json& total);

void add_compare_command(const Command& program);

}  // namespace engram::apps
