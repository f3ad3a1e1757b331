// `engram bench`: side-by-side benchmarks.
#pragma once

#include "apps/command_line.h"

namespace engram::apps {

void add_bench_command(const Command& program);

}  // namespace engram::apps
