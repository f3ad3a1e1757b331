// Scripted policies of a task. They may read privileged state; nothing else of a task writes
// actions.
#pragma once

#include "core/task/task.h"

namespace engram {

// Scripted policies: one that knows the hidden quantity, one that guesses it, and the best one
// without memory. An action of the last is a function of what can be seen now, of where the robot
// is, and of the step count.
enum class Script { kOracle, kBlind, kSweep };

class Expert {
 public:
  virtual ~Expert() = default;

  // Writes actions for pd_ee_delta_pose with rotation sign -1. One call per range of environments;
  // different ranges may be worked on at the same time by different threads.
  virtual void act(Range envs, Script script, FloatRows actions) const = 0;
};

}  // namespace engram
