// `engram list`: the registry.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_list_command(CLI::App& app);

}  // namespace engram::apps
