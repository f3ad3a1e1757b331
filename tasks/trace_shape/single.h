// TraceShape: a red cube traces a shape; a green one has to be led along the same contour
// (docs/tasks/trace_shape.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// TraceShape{Easy,Medium,Hard}-VLA-v0.
extern const Family kTraceShape;

}  // namespace engram::tasks
