// `engram collect`: demonstrations to learn from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// task_options: as in apps/play_command.h.
void add_collect_command(const Command& program,
                         const std::shared_ptr<const std::vector<std::string>>& task_options);

}  // namespace engram::apps
