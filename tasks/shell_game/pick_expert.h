// Expert of ShellGamePick: straddles the handle's bar from above, closes, lifts.
#pragma once

#include "tasks/shell_game/expert.h"

namespace engram::tasks {

class PickExpert final : public ShellGameExpert {
 public:
  // `lift`: of a mug to the goal region, m.
  PickExpert(const ShellGame& game, const ShellGameParams& params, double lift);

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  void pick(int env, int slot, float* action) const;
  double remaining_turn(int env) const;

  Eigen::Vector3d grip_from_mug_;  // m
  double grip_height_;             // m
  double hover_height_;            // m
  double grip_radius_;             // m
  double holding_width_;           // m
  double lift_;                    // m
  Eigen::Quaterniond grip_tool_;
};

}  // namespace engram::tasks
