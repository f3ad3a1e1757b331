// `engram play`: episodes in the browser. The page is served by the Python package.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// task_options: --tasks and --variants as given so far, for processes that the command starts.
void add_play_command(const Command& program,
                      const std::shared_ptr<const std::vector<std::string>>& task_options);

}  // namespace engram::apps
