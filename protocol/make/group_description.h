// The description of a group of batches.
#pragma once

#include "protocol/io/json.h"
#include "protocol/make/make.h"

namespace engram {

// A single batch's description is describe_task's. Several tasks': what they have in common, under
// these keys, and "tasks", the description of each with its environments.
ConstantTable describe_group(const Batch& group);

}  // namespace engram
