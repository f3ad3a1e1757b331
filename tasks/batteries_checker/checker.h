// BatteriesChecker: put batteries into the socket, see whether the lamp lights up, bring them back
// to their slots (in the easy variants they go there by themselves) and confirm with the button,
// until all that work are found (docs/tasks/batteries_checker.md).
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// BatteriesChecker{Easy,Hard}-{3,6,9,12,15}-VLA-v0.
extern const Family kBatteriesCheckerEasy;
extern const Family kBatteriesCheckerHard;

}  // namespace engram::tasks
