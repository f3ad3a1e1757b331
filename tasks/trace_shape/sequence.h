// TraceShapeSeq: a red cube traces several shapes; a green one has to be led along the same
// contours in the same order, then the button pressed (docs/tasks/trace_shape.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// TraceShapeSeq{Easy,Medium,Hard}-VLA-v0.
extern const Family kTraceShapeSeq;

}  // namespace engram::tasks
