// An environment's episode in words, as a table.
#pragma once

#include "core/batch/batch.h"
#include "protocol/io/json.h"

namespace engram {

// Words of the present state: plan, subtask (its index), subtasks_done, memory, object (the name of
// a prop, or null), and paraphrases of the instruction. Privileged, apart from these. Throws Error
// before the first reset, and if the task has no words.
JsonTable describe_words(const Batch& batch, int index);

}  // namespace engram
