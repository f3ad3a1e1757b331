// Words of the Remember and Find-Imposter families: what was shown, and which object to touch.
#pragma once

#include "core/task/annotator.h"
#include "core/task/task.h"
#include "tasks/common/phase_clock.h"
#include "tasks/remember/object_set.h"

namespace engram::tasks {

class ObjectRecallAnnotator final : public Annotator {
 public:
  // Privileged view of the task. Objects are its first props, keys are indices.
  struct View {
    const Bindings& engine;
    const ObjectSet& objects;
    const PhaseClock& clock;
    const Column<std::int32_t>& target;  // hidden: key
    double goal_thresh;                  // m
    bool imposter;                       // the cue shows all objects but the target
  };

  explicit ObjectRecallAnnotator(const View& view) : view_(view) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  Phase phase(int env) const { return view_.clock.phase(env, view_.engine.state->elapsed[env]); }
  std::string cue_subtask() const;
  std::string target_words(int env) const;

  View view_;
};

}  // namespace engram::tasks
