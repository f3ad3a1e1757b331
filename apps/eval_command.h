// `engram eval`: the evaluation protocol (docs/protocol.md), with built-in or external policies.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_eval_command(CLI::App& app);

}  // namespace engram::apps
