// Comparisons of the first answers of two trials.
#pragma once

#include "protocol/eval/probe/trial.h"
#include "tasks/family.h"

namespace engram {

// any_order: the digits of an answer count in any order.
bool same_answer(const TrialResult& one, const TrialResult& other, bool any_order);

// Whether a trial that came to another scene answered there as one of the same past did in its own
// scene, as far as the scene let it.
bool answers_as(const TrialResult& in_other_scene, const TrialResult& in_own_scene, AnswerCut cut);

}  // namespace engram
