// `engram probe`: does a policy read its memory?
#pragma once

#include <vector>

#include "apps/command_line.h"
#include "protocol/eval/probe/probe_run.h"

namespace engram::apps {

void print_probes(const Json& document, const std::vector<Probe>& probes, bool json);
// What a run does, as its journal has it.
ProbeOptions probes_of(const Json& run);

void add_probe_command(const Command& program);

}  // namespace engram::apps
