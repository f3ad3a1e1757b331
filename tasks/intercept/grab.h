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

// Dense reward (tasks/common/reward_dict.h).
struct GrabReward {
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
  // Terms.
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // ball to TCP along each axis, m
  double distance = 0;                               // ball to TCP, m
  bool in_gripper = false;
  bool very_close = false;
  double ball_stillness = 0;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("tcp_to_obj_dist", "m", distance);
    row.term("is_grasped_reward", "", grasped);
    row.term("ball_in_gripper", "", in_gripper);
    row.term("dist_tcp_to_ball_x", "m", offset.x());
    row.term("dist_tcp_to_ball_y", "m", offset.y());
    row.term("dist_tcp_to_ball_z", "m", offset.z());
    row.term("current_gripper_width", "m", gripper_width);
    row.term("very_close_mask", "", very_close);
    row.term("static_reward", "", ball_stillness);
    row.term("robot_static_reward", "", robot_static);
    row.term("success", "", success);
  }
};

extern const Family kInterceptGrab;

}  // namespace engram::tasks
