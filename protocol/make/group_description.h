// The description of a group of batches.
#pragma once

#include "protocol/io/json.h"
#include "protocol/make/make.h"

namespace engram {

// Of a single batch: describe_task. Of several tasks: what they have in common, under the same
// keys, and "tasks", the description of each with its environments.
ConstantTable describe_group(const BatchGroup& group);

}  // namespace engram
