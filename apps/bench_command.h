// `engram bench`: side-by-side benchmarks.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_bench_command(CLI::App& app);

}  // namespace engram::apps
