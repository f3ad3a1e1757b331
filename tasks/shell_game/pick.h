// ShellGamePick: the mug that hides the ball has to be picked up by its handle and lifted, the ball
// in it, to a goal.
#pragma once

#include <Eigen/Core>

#include "tasks/family.h"

namespace engram::tasks {

// Inputs of the dense reward.
struct PickInputs {
  double to_handle = 0;      // TCP to the handle, m
  double to_goal = 0;        // mug or ball to the goal's centre, m
  double arm_speed = 0;      // rad/s
  double gripper_width = 0;  // m: 0 closed, 0.08 open
  bool grasped = false;
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
  // For reward_dict alone.
  double to_mug = 0;                                        // TCP to the mug, m
  Eigen::Vector3d handle_offset = Eigen::Vector3d::Zero();  // TCP to the handle, m
};

struct PickTerms {
  double reaching = 0;
  double open = 0;
  double grasp = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;
  double reward = 0;
};

// The dense reward: 0 outside the manipulation phase, 75 at success.
PickTerms pick_reward(const PickInputs& inputs);

// ShellGamePick-VLA-v0 and ShellGamePick-v0.
extern const Family kShellGamePick;

}  // namespace engram::tasks
