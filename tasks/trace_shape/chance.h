// Success rates of guessing in TraceShape and TraceShapeSeq, without the demonstration.
#pragma once

#include "core/task/task.h"
#include "tasks/trace_shape/params.h"

namespace engram::tasks {

// Answers: sequences of shapes, of any length that may be drawn.
int count_sequences(const TraceParams& params);

// The success rate of a guess: measured for the benchmark's constants, otherwise estimated.
void describe_guess(const TraceParams& params, TaskInfo& info);

// Rate where shapes alone are guessed, and traced as large and turned as they were shown.
double choice_rate(const TraceParams& params);

// Share of right first answers.
double answer_rate(const TraceParams& params);

}  // namespace engram::tasks
