// The tasks whose answers can be chosen from a list.
#pragma once

#include "protocol/eval/run/settings.h"

namespace engram {

// Throws Error, naming the tasks that have choices, unless all of these have; and unless the hand
// that carries them out knows the control mode.
void require_choices(const EvaluationSettings& settings);

}  // namespace engram
