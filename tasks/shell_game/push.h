// ShellGamePush: the mug that hides the ball has to be pushed forward, to bring the ball to a goal.
#pragma once

#include "tasks/family.h"

namespace engram::tasks {

// Dense reward (tasks/common/reward_dict.h): 0 outside the manipulation phase, 4 at success.
struct PushReward {
  double distance = 0;   // TCP to the mug, m
  double to_goal = 0;    // mug or ball to the goal's centre, m
  double arm_speed = 0;  // rad/s
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
  bool lists_static = true;  // in reward_dict
  // Terms.
  double reaching = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("static_reward", "", stillness);
    if (lists_static) row.term("is_robot_static", "", robot_static);
    row.term("place_reward", "", place);
    row.term("tcp_to_obj_dist", "m", distance);
    row.term("obj_to_goal_dist", "m", to_goal);
    row.term("info[\"is_obj_placed\"]", "", placed);
    row.term("reached_status", "", reached);
  }
};

// ShellGamePush-VLA-v0 and ShellGamePush-v0.
extern const Family kShellGamePush;

}  // namespace engram::tasks
