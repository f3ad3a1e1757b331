// `engram check`: whether tasks are sound. The Python package checks them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// task_options: --tasks and --variants as given so far, for the process that checks.
void add_check_command(const Command& program,
                       const std::shared_ptr<const std::vector<std::string>>& task_options);

}  // namespace engram::apps
