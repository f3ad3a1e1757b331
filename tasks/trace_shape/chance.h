// Success rates of guessing in TraceShape and TraceShapeSeq, without the demonstration.
#pragma once

#include "tasks/trace_shape/params.h"

namespace engram::tasks {

// Answers: sequences of shapes, of any length that may be drawn.
int count_sequences(const TraceParams& params);

double guess_rate(const TraceParams& params);

// Rate where shapes alone are guessed, and traced as large and turned as they were shown.
double choice_rate(const TraceParams& params);

// Share of right first answers.
double answer_rate(const TraceParams& params);

}  // namespace engram::tasks
