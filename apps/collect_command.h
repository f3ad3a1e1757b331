// `engram collect`: demonstrations to learn from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// variants: files that the program was given.
void add_collect_command(const Command& program,
                         const std::shared_ptr<const std::vector<std::string>>& variants);

}  // namespace engram::apps
