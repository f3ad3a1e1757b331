// From an id to a task that can be run.
#pragma once

#include <memory>
#include <string_view>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram {

// Throws Error with the nearest id if there is no such task.
std::unique_ptr<Task> make_task(std::string_view id);

// The registered task of that id. Throws Error with the nearest id if there is none.
const RegistryEntry& require_entry(std::string_view id);

}  // namespace engram
