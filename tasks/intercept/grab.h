// InterceptGrab: catch the rolling ball.
#pragma once

#include <memory>

#include "core/task.h"
#include "tasks/registry_table.h"

namespace engram::tasks {

// What the dense reward is made of (intercept 2.4).
struct GrabRewardInputs {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  double gripper_width = 0;  // m
  bool grasped = false;
  bool success = false;
};

struct GrabRewardTerms {
  double distance = 0;  // ball to TCP, m
  bool in_gripper = false;
  bool very_close = false;
  double reward = 0;
};

GrabRewardTerms grab_reward(const GrabRewardInputs& inputs);

std::unique_ptr<Task> make_intercept_grab(const RegistryEntry& entry);

}  // namespace engram::tasks
