// BlinkCountButtonPress: a lamp blinks some times, then the red button has to be pressed as often
// and the black one once (docs/tasks/blink_count.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// BlinkCountButtonPress{Easy,Medium,Hard}-VLA-v0 and -Long-VLA-v0.
std::unique_ptr<Task> make_blink_count(const RegistryEntry& entry);

}  // namespace engram::tasks
