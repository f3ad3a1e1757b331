// `engram eval`: the evaluation protocol (common 12.2) with the built-in policies.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_eval_command(CLI::App& app);

}  // namespace engram::apps
