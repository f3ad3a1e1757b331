// Expert of ShellGamePush: comes down behind the mug and goes forward with the fingers closed until
// the mug has moved far enough.
#pragma once

#include "tasks/shell_game/expert.h"

namespace engram::tasks {

class PushExpert final : public ShellGameExpert {
 public:
  PushExpert(const ShellGame& game, const ShellGameParams& params);

  // travel: of a mug to the goal region, m.
  // reach: radius of that, m.
  void set_goal(double travel, double reach);
  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  void push(int env, int slot, float* action) const;
  void sweep(int env, float* action) const;

  // m
  double behind_;       // the mug's origin
  double push_height_;  // of the TCP
  double travel_ = 0;   // of the mug
  double lead_ = 0;     // of the tool's target ahead of it
  double half_pitch_;   // of the slots
};

}  // namespace engram::tasks
