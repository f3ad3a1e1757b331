// Expert of ShellGamePick: straddles the handle's bar from above, closes, lifts.
#pragma once

#include "tasks/shell_game/expert.h"

namespace engram::tasks {

class PickExpert final : public ShellGameExpert {
 public:
  PickExpert(const ShellGame& game, const ShellGameParams& params);

  // The mug has to be lifted by `lift`, m.
  void lift_mug(double lift);
  // The ball in it has to come within `reach` of a point `height` above where it lies, m.
  void lift_ball(double height, double reach);

  void act(Range envs, Script script, FloatRows actions) const override;

 private:
  void pick(int env, int slot, float* action) const;
  Eigen::Vector3d raised(int env, int slot) const;
  // Orientation of the tool that straddles the bar.
  Eigen::Quaterniond grip_tool(int env) const;
  double remaining_turn(int env) const;

  bool waits_;                     // for the mugs to appear
  Eigen::Vector3d grip_from_mug_;  // m, of a handle that is not turned
  double grip_height_;             // m
  double hover_height_;            // m
  double grip_radius_;             // m
  double holding_width_;           // m
  double lift_ = 0;                // of a mug, m
  bool ball_ = false;              // it counts where the ball comes
  double ball_height_ = 0;         // of its goal above its slot, m
};

}  // namespace engram::tasks
