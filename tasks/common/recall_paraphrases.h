// Wordings of instructions: one thing is remembered, then an object is touched, pushed or picked
// up.
#pragma once

#include <span>

#include "tasks/common/paraphrase_set.h"

namespace engram {

std::span<const ParaphraseSet> recall_paraphrases();

}  // namespace engram
