// ShellGamePush: the mug that hides the ball has to be pushed forward, to bring the ball to a goal.
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// Inputs of the dense reward.
struct PushInputs {
  double distance = 0;   // TCP to the mug, m
  double to_goal = 0;    // mug or ball to the goal's centre, m
  double arm_speed = 0;  // rad/s
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
};

struct PushTerms {
  double reaching = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;
  double reward = 0;
};

// The dense reward: 0 outside the manipulation phase, 4 at success.
PushTerms push_reward(const PushInputs& inputs);

// ShellGamePush-VLA-v0 and ShellGamePush-v0.
extern const Family kShellGamePush;

}  // namespace engram::tasks
