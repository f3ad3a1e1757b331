// `engram soak`: long runs that watch for growth, drift and instability.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_soak_command(CLI::App& app);

}  // namespace engram::apps
