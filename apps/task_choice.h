// The tasks that a command works on.
#pragma once

#include <string>
#include <vector>

#include "apps/options.h"

namespace engram::apps {

// The tasks of these ids, or all that pass the filter. Throws Error unless tasks are chosen, in one
// of the two ways.
std::vector<const RegistryEntry*> chosen_tasks(const std::vector<std::string>& ids,
                                               const TaskFilter& filter, bool all);

}  // namespace engram::apps
