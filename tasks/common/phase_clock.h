// The cue, empty, manipulation sequence that most families have.
#pragma once

#include "core/base/column.h"
#include "tasks/common/sampled_range.h"

namespace engram::tasks {

enum class Phase { kCue, kEmpty, kManipulation };

// Cue while elapsed < C, empty while elapsed < C + E, then manipulation.
class PhaseClock {
 public:
  void bind(ColumnStore& memory) {
    cue_steps_ = memory.add<std::int32_t>("cue_steps", 1, "control steps");
    empty_steps_ = memory.add<std::int32_t>("empty_steps", 1, "control steps");
  }

  void reset(int env, int cue_steps, int empty_steps) const {
    cue_steps_[env] = cue_steps;
    empty_steps_[env] = empty_steps;
  }

  Phase phase(int env, int elapsed) const {
    if (elapsed < cue_steps_[env]) return Phase::kCue;
    return elapsed < manipulation_start(env) ? Phase::kEmpty : Phase::kManipulation;
  }
  // True in the one step in which a phase begins; elapsed 0 begins the cue.
  bool begins(int env, int elapsed) const {
    return elapsed == 0 || elapsed == cue_steps_[env] || elapsed == manipulation_start(env);
  }
  // The values of elapsed at which the cue is over, and at which the robot may act.
  int cue_end(int env) const { return cue_steps_[env]; }
  int manipulation_start(int env) const { return cue_steps_[env] + empty_steps_[env]; }

  // The lengths of the phases, as scripts for the original benchmark name them.
  template <class Visitor>
  void sampled_row(Visitor& row, int env) const {
    row.field("cue_steps_per_env", 1, "control steps", "length of the cue phase",
              [&] { return cue_steps_[env]; });
    row.field("empty_steps_per_env", 1, "control steps", "length of the empty phase",
              [&] { return empty_steps_[env]; });
  }

 private:
  Column<std::int32_t> cue_steps_;
  Column<std::int32_t> empty_steps_;
};

}  // namespace engram::tasks
