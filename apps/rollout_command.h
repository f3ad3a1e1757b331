// `engram rollout`: batched rollouts and their speed.
#pragma once

#include <CLI/CLI.hpp>

namespace engram::apps {

void add_rollout_command(CLI::App& app);

}  // namespace engram::apps
