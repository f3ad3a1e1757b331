// Intercept: bring the rolling ball onto the target (docs/tasks/intercept.md).
#pragma once

#include <Eigen/Core>

#include "tasks/family.h"

namespace engram::tasks {

// Dense reward (tasks/common/reward_dict.h).
struct InterceptReward {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  bool reached = false;  // in an earlier step, or, once computed, in this one
  bool success = false;
  double ball_radius = 0.02;  // m
  double penalty = 0;         // on large and abrupt actions
  // Terms.
  double reaching = 0;
  double place = 0;
  double tcp_to_hit_pose_dist = 0;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("reached_status", "", reached);
    row.term("place_reward", "", place);
    row.term("tcp_to_hit_pose_dist", "m", tcp_to_hit_pose_dist);
  }
};

extern const Family kIntercept;

}  // namespace engram::tasks
