// TraceShape: a red cube traces a shape; a green one has to be led along the same contour
// (docs/tasks/trace_shape.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// TraceShape{Easy,Medium,Hard}-VLA-v0.
std::unique_ptr<Task> make_trace_shape(const RegistryEntry& entry);

}  // namespace engram::tasks
