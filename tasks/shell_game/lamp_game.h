// The shell games with a lamp: the mug of the lamp's colour has to be touched (shell 5 and 7).
#pragma once

#include "tasks/shell_game/lamp_cue.h"
#include "tasks/shell_game/touch_game.h"

namespace engram::tasks {

// What ColorLamp and ShuffleLamp have in common. They differ in how mugs move and so in the slot in
// which the mug of a colour ends.
class ShellLampGame : public ShellTouchGame {
 public:
  void bind(const Bindings& bindings) override;
  void observe(Range envs, FloatRows out) override;

 protected:
  ShellLampGame(const RegistryEntry& entry, Setup setup);

  // Draws the mapping and shows the cue; `draw` is the index of its draw.
  void reset_cue(const Episode& episode, int draw) const;
  // Success for the mug of the lamp's colour, which ends in `slot`.
  void judge_slot(int env, int slot) const;
  int target_mug(int env) const { return cue_.mug_of(env, target_[env]); }

  ShellLampCue cue_;

 private:
  Column<float> task_cue_;
};

}  // namespace engram::tasks
