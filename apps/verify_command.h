// engram verify: the same seeds give the same bits, however a batch is run.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_verify_command(CLI::App& app);

}  // namespace engram::apps
