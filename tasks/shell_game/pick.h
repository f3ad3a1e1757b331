// ShellGamePick: the mug that hides the ball has to be picked up by its handle and lifted, the ball
// in it, to a goal.
#pragma once

#include <Eigen/Core>

#include "tasks/family.h"

namespace engram::tasks {

// Dense reward (tasks/common/reward_dict.h): 0 outside the manipulation phase, 75 at success.
struct PickReward {
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
  // Terms.
  double reaching = 0;
  double open = 0;
  double grasp = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("open_gripper_reward", "", open);
    row.term("grasp_reward", "", grasp);
    row.term("reached_status", "", reached);
    row.term("info[\"is_grasped\"]", "", grasped);
    row.term("place_reward", "", place);
    row.term("static_reward", "", stillness);
    row.term("tcp_to_handle_dist", "m", to_handle);
    row.term("tcp_to_obj_dist", "m", to_mug);
    row.term("obj_to_goal_dist", "m", to_goal);
    row.term("info[\"is_obj_placed\"]", "", placed);
    row.term("gripper_width", "m", gripper_width);
    row.term("dx_handle", "m", handle_offset.x());
    row.term("dy_handle", "m", handle_offset.y());
    row.term("dz_handle", "m", handle_offset.z());
  }
};

// ShellGamePick-VLA-v0 and ShellGamePick-v0.
extern const Family kShellGamePick;

}  // namespace engram::tasks
