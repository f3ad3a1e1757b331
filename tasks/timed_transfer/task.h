// TimedTransfer: a cube has to be moved from one disc to another a given number of steps after a
// lamp turned green (docs/tasks/timed_transfer.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// TimedTransfer{Easy,Medium,Hard}-VLA-v0 and -Long-VLA-v0.
extern const Family kTimedTransfer;

}  // namespace engram::tasks
