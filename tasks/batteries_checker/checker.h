// BatteriesChecker: put every battery into the socket, see whether the lamp lights up, bring it
// back to its slot (in the easy variants it goes there by itself) and confirm with the button
// (docs/tasks/batteries_checker.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// BatteriesChecker{Easy,Hard}-{3,6,9,12,15}-VLA-v0.
extern const Family kBatteriesCheckerEasy;
extern const Family kBatteriesCheckerHard;

}  // namespace engram::tasks
