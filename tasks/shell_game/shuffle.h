// The shuffles: after the cue the mugs swap places, and the right one has to be followed.
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// ShellGameShuffleTouch-VLA-v0 and -Long-VLA-v0.
extern const Family kShellGameShuffleTouch;

// ShellGameShuffleColorLampTouch-VLA-v0 and -Long-VLA-v0.
extern const Family kShellGameShuffleColorLampTouch;

}  // namespace engram::tasks
