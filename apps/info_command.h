// `engram info`: one task in full.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_info_command(CLI::App& app);

}  // namespace engram::apps
