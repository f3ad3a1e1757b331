// TraceShapeSeq: a red cube traces several shapes; a green one has to be led along the same
// contours in the same order, then the button pressed (docs/tasks/trace_shape.md).
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// TraceShapeSeq{Easy,Medium,Hard}-VLA-v0.
std::unique_ptr<Task> make_trace_shape_seq(const RegistryEntry& entry);

}  // namespace engram::tasks
