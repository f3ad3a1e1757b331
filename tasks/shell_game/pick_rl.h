// ShellGamePick of the RL half: the mug that hides the ball has to come to a goal above its slot,
// however that is done. The reward leads the tool to the mug's origin and knows no handle.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/task/task.h"
#include "tasks/registry.h"

namespace engram::tasks {

// Inputs of the dense reward.
struct MugPickInputs {
  double to_goal = 0;    // mug to the goal's centre, m
  double arm_speed = 0;  // rad/s
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // TCP to the mug's origin, m
  bool grasped = false;                              // for reward_dict alone
};

struct MugPickTerms {
  double reaching = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;
  double reward = 0;
};

// The dense reward: 0 outside the manipulation phase, 75 at success.
MugPickTerms mug_pick_reward(const MugPickInputs& inputs);

// Makes ShellGamePick-v0.
std::unique_ptr<Task> make_mug_pick(const RegistryEntry& entry, const ConstantTable& constants);

}  // namespace engram::tasks
