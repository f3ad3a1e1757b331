// Flags of evaluations, records and probes that api/surface.toml lists.
#pragma once

#include <string_view>

#include "apps/command_line.h"
#include "protocol/eval/run/run_options.h"

namespace engram::apps {

// name: the command: "eval", "record" or "probe".
void add_run_flags(const Command& command, std::string_view name, RunOptions& run);

}  // namespace engram::apps
