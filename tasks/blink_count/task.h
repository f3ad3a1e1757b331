// BlinkCountButtonPress: a lamp blinks some times, then the red button has to be pressed as often
// and the black one once (docs/tasks/blink_count.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// BlinkCountButtonPress{Easy,Medium,Hard}-VLA-v0 and -Long-VLA-v0.
extern const Family kBlinkCountButtonPress;

}  // namespace engram::tasks
