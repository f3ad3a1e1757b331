// `engram collect`: demonstrations to learn from.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_collect_command(CLI::App& app);

}  // namespace engram::apps
