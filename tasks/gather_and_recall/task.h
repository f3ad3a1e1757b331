// GatherAndRecall: bring all cubes onto a disc; a lamp flashes once meanwhile, and at the end the
// button of its colour has to be pressed (docs/tasks/gather_and_recall.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// GatherAndRecall{1,3,5,7,9}-VLA-v0.
extern const Family kGatherAndRecall;

}  // namespace engram::tasks
