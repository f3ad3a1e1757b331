// `engram serve`: a policy server, in Python (docs/policy_servers.md).
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

void add_serve_command(const Command& program,
                       const std::shared_ptr<const std::vector<std::string>>& task_options);

}  // namespace engram::apps
