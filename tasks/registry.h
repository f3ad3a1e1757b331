// From an id to a task that can be run.
#pragma once

#include <memory>
#include <string_view>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram {

// Throws Error: kUnknownId, with the nearest id, if there is no such task; kUnavailable if its
// family is registered but not part of this version.
std::unique_ptr<Task> make_task(std::string_view id);

// The registered task of that id. Throws Error with the nearest id if there is none.
const RegistryEntry& require_entry(std::string_view id);

// Whether make_task can make the task.
bool is_implemented(const RegistryEntry& entry);

}  // namespace engram
