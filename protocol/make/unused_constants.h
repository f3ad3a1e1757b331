// Constants of a user's that a rule set does not use.
#pragma once

#include <string>
#include <vector>

#include "core/batch/batch.h"

namespace engram {

// A warning for every constant that sets the default of a task option, where the rules set the
// option to something else and the user has not chosen its value.
std::vector<std::string> unused_constants(const TaskInfo& info, const BatchOptions& options);

}  // namespace engram
