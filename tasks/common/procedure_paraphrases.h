// Wordings of instructions: motions, sequences, counts and checks.
#pragma once

#include <span>

#include "tasks/common/paraphrase_set.h"

namespace engram {

std::span<const ParaphraseSet> procedure_paraphrases();

}  // namespace engram
