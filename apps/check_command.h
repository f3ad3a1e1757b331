// `engram check`: whether tasks are sound. The Python package checks them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// variants: files that --variants has named so far.
void add_check_command(const Command& program,
                       const std::shared_ptr<const std::vector<std::string>>& variants);

}  // namespace engram::apps
