// `engram play`: episodes in the browser. The page is served by the Python package.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"

namespace engram::apps {

// variants: files that --variants has named so far.
void add_play_command(const Command& program,
                      const std::shared_ptr<const std::vector<std::string>>& variants);

}  // namespace engram::apps
