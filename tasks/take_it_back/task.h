// TakeItBack: bring the cube onto the target, and when that changes colour, back to where it was.
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// What the dense reward is made of (take 5.6).
struct TakeItBackRewardInputs {
  Eigen::Vector3d cube = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  Eigen::Vector2d goal = Eigen::Vector2d::Zero();
  Eigen::Vector2d initial = Eigen::Vector2d::Zero();
  double penalty = 0;  // of hasty actions
  bool reached = false;
  bool success = false;
};

struct TakeItBackRewardTerms {
  double push_distance = 0;  // TCP to the point from which to push, m
  double pull_distance = 0;
  double reaching_push = 0;
  double reaching_pull = 0;
  double contact = 0;
  double in_goal = 0;
  double back = 0;
  double reward = 0;
};

TakeItBackRewardTerms take_it_back_reward(const TakeItBackRewardInputs& inputs);

std::unique_ptr<Task> make_take_it_back(const RegistryEntry& entry);

}  // namespace engram::tasks
