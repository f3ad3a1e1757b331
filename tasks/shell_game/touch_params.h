// Parameters of the shell games in which a mug is touched.
#pragma once

#include "tasks/shell_game/params.h"

namespace engram::tasks {

struct TouchParams : ShellGameParams {
  // Height of the TCP above the origin of a mug that the oracle touches, m.
  double touch_gap() const;

  void check(int horizon) const;
  // Checks a game that goes on with other phases after the cue.
  void check_touch() const;
};

}  // namespace engram::tasks
