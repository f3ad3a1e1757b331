// GatherAndRecall: bring all cubes onto a disc; a lamp flashes once meanwhile, and at the end the
// button of its colour has to be pressed (docs/tasks/gather_and_recall.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// GatherAndRecall{1,3,5,7,9}-VLA-v0.
std::unique_ptr<Task> make_gather_and_recall(const RegistryEntry& entry);

}  // namespace engram::tasks
