// Expert of ShellGamePush: comes down behind the mug and goes forward with the fingers closed until
// the mug has moved far enough.
#pragma once

#include "tasks/shell_game/expert.h"

namespace engram::tasks {

class PushExpert final : public ShellGameExpert {
 public:
  PushExpert(const ShellGame& game, const ShellGameParams& params);

  // travel: of a mug to the goal region, m.
  // reach: of `item` from the goal's centre, m.
  // leeway: by which it may go farther or less far than to the goal's centre, m.
  void set_goal(GoalItem item, double travel, double reach, double leeway);
  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  void push(int env, int slot, float* action) const;
  void sweep(int env, float* action) const;

  // m
  double behind_;       // the mug's origin
  double push_height_;  // of the TCP
  double travel_ = 0;   // of the mug
  double lead_ = 0;     // of the tool's target ahead of it
  double first_lead_ = 0;
  double half_pitch_;  // of the slots
  double sweep_travel_ = 0;
  double sweep_lead_ = 0;
};

}  // namespace engram::tasks
