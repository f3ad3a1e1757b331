// TimedTransfer: a cube has to be moved from one disc to another exactly so many steps after a lamp
// turned green (docs/tasks/timed_transfer.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// TimedTransfer{Easy,Medium,Hard}-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_timed_transfer(const RegistryEntry& entry);

}  // namespace engram::tasks
