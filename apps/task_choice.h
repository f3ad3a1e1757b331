// The tasks that a command works on.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "apps/options.h"

namespace engram::apps {

// The tasks of these ids, or all that pass the filter; RL tasks only if the filter names their
// split, since results of the two halves do not belong together. Throws Error unless tasks are
// chosen, in one of the two ways.
std::vector<const RegistryEntry*> chosen_tasks(const std::vector<std::string>& ids,
                                               const TaskFilter& filter, bool all);

// Warns of constants without effect and of those with which the oracle fails, of each once.
void warn_of_constants(std::span<const RegistryEntry* const> tasks, const MakeOptions& options);
void warn_of_constants(std::string_view id, const MakeOptions& options);

}  // namespace engram::apps
