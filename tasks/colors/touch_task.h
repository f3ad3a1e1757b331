// The RL tasks of BunchOfColors, SeqOfColors and ChainOfColors: the cubes have to be touched, and
// that is all. An episode ends with the last touch.
#pragma once

#include "tasks/colors/annotator.h"
#include "tasks/colors/expert.h"
#include "tasks/colors/touch_base.h"

namespace engram::tasks {

class ColorTouch final : public ColorTouchBase {
 public:
  ColorTouch(const RegistryEntry& entry, const ColorRecallParams& params);

  void bind(const Bindings& bindings) override;
  void reset(const Episode& episode) override { begin_episode(episode); }
  void advance(Range envs) override;
  void evaluate(Range envs) override;
  void dense_reward(Range envs, FloatRows out) override;
  void observe(Range envs, FloatRows out) override { write_state(*this, envs, out); }
  template <class Visitor>
  void state_row(Visitor& row, int env) const {
    goal_fields(row, env);
    cube_fields(row, env, [&] { return next_target(env); });
  }
  const Expert& expert() const override { return expert_; }
  const Annotator* annotator() const override { return &annotator_; }

 private:
  int next_target(int env) const;

  ColorRecallExpert expert_;
  ColorRecallAnnotator annotator_;
};

}  // namespace engram::tasks
