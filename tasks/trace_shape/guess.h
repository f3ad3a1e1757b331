// How often somebody succeeds in TraceShape or TraceShapeSeq who has not seen the demonstration.
#pragma once

#include "tasks/trace_shape/params.h"

namespace engram::tasks {

// Answers: sequences of shapes, of any length that may be drawn.
int count_sequences(const TraceParams& params);

double guess_rate(const TraceParams& params);

// How often the first answer is right.
double answer_rate(const TraceParams& params);

}  // namespace engram::tasks
