// The shell games in which the right mug is touched: the TCP comes within GOAL_THRESH of it and the
// robot stands still, whether anything is in contact or not (shell 2, 5, 6.3, 7).
#pragma once

#include <string>
#include <vector>

#include "tasks/shell_game/game.h"

namespace engram::tasks {

struct ShellTouchInputs {
  double distance = 0;      // TCP to goal, m
  double arm_speed = 0;     // rad/s
  double displacement = 0;  // farthest that a mug was shoved, m
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
};

struct ShellTouchTerms {
  double reaching = 0;
  double stillness = 0;
  double shift = 0;
  double reward = 0;
};

// The dense reward of shell 2; 0 outside the manipulation phase, 3 at success.
ShellTouchTerms shell_touch_reward(const ShellTouchInputs& inputs);

class ShellTouchGame : public ShellGame {
 public:
  void bind(const Bindings& bindings) override;
  void dense_reward(Range envs, FloatRows out) override;
  void act(Range envs, bool blind, FloatRows actions) override;

 protected:
  // `shoving`: whether info tells how far mugs were shoved, and success depends on it.
  ShellTouchGame(const RegistryEntry& entry, const Setup& setup, bool shoving);

  // Success of a TCP at the goal, with mugs that were shoved by at most `displacement` m.
  void judge(int env, const Eigen::Vector3d& goal, double displacement = 0) const;

 private:
  bool shoving_;
  Column<double> displacement_;  // m
  Column<float> mug_max_displacement_;
  Column<std::uint8_t> is_mug_displacement_ok_;
};

}  // namespace engram::tasks
