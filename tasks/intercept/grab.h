// InterceptGrab: catch the rolling ball (docs/tasks/intercept.md).
#pragma once

#include <Eigen/Core>

#include "tasks/family.h"

namespace engram::tasks {

// Parts of the dense reward.
struct GrabBonuses {
  double attempt = 90;  // for fingers that close around the ball
  double grasp = 200;
};

// Inputs of the dense reward.
struct GrabRewardInputs {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  double gripper_width = 0;  // m
  bool grasped = false;
  bool success = false;
  double ball_radius = 0.02;  // m
  double penalty = 0;         // on large and abrupt actions
  GrabBonuses bonuses = {};
  // For reward_dict alone.
  double ball_speed = 0;  // m/s
  double ball_spin = 0;   // rad/s
  bool robot_static = false;
};

struct GrabRewardTerms {
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // ball to TCP along each axis, m
  double distance = 0;                               // ball to TCP, m
  bool in_gripper = false;
  bool very_close = false;
  double ball_stillness = 0;
  double reward = 0;
};

GrabRewardTerms grab_reward(const GrabRewardInputs& inputs);

extern const Family kInterceptGrab;

}  // namespace engram::tasks
