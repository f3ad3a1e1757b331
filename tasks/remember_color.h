// RememberColor: one cube shows its colour, all vanish, then K cubes appear and the one of that
// colour has to be touched (remember_and_find_imposter.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// RememberColor{3,5,9}-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_remember_color(const RegistryEntry& entry);

}  // namespace engram::tasks
