// Intercept: bring the rolling ball onto the target (docs/tasks/intercept.md).
#pragma once

#include <Eigen/Core>

#include "tasks/family.h"

namespace engram::tasks {

// Inputs of the dense reward.
struct InterceptRewardInputs {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  bool reached = false;  // in an earlier step
  bool success = false;
  double ball_radius = 0.02;  // m
  double penalty = 0;         // on large and abrupt actions
};

struct InterceptRewardTerms {
  double reaching = 0;
  double place = 0;
  double tcp_to_hit_pose_dist = 0;
  bool reached = false;
  double reward = 0;
};

InterceptRewardTerms intercept_reward(const InterceptRewardInputs& inputs);

extern const Family kIntercept;

}  // namespace engram::tasks
