// Words of SeqOfColors, ChainOfColors and BunchOfColors: the colours of the cue, and the cube to
// touch next.
#pragma once

#include "core/task/annotator.h"
#include "tasks/colors/expert.h"

namespace engram::tasks {

class ColorRecallAnnotator final : public Annotator {
 public:
  // The expert, which outlives this object, knows the task.
  explicit ColorRecallAnnotator(const ColorRecallExpert& expert)
      : view_(expert.view()), expert_(expert) {}

  std::vector<std::string> plan(int env) const override;
  int subtask(int env) const override;
  int subtasks_done(int env) const override;
  std::string memory(int env) const override;
  int object(int env) const override;

 private:
  int length() const { return view_.params.SEQUENCE_LENGTH; }
  int elapsed(int env) const { return view_.engine.state->elapsed[env]; }
  bool has_button() const { return view_.button != nullptr; }
  int last_subtask() const;
  bool is_chain() const { return view_.params.rule == ColorRule::kChain; }
  Phase phase(int env) const { return view_.clock.phase(env, elapsed(env)); }
  int color(int env, int item) const { return view_.sequence.row(env)[item]; }
  int shown(int env) const;

  const ColorRecallExpert::View& view_;
  const ColorRecallExpert& expert_;
};

}  // namespace engram::tasks
