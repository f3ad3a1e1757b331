// TakeItBack: bring the cube onto the target, and when that changes colour, back to where it was
// (docs/tasks/take_it_back.md).
#pragma once

#include <Eigen/Core>

#include "tasks/common/action_cost.h"
#include "tasks/family.h"

namespace engram::tasks {

// Parts of the dense reward.
struct TakeItBackShaping {
  double in_place = 0.03;       // m: so near to the point from which to push, or to pull
  double in_goal_weight = 1.5;  // of a cube near the target, whatever the hand does
  double contact_weight = 4;    // of a hand near the cube, on the way back
};

// Dense reward (tasks/common/reward_dict.h).
struct TakeItBackReward {
  Eigen::Vector3d cube = Eigen::Vector3d::Zero();
  Eigen::Vector3d tcp = Eigen::Vector3d::Zero();
  Eigen::Vector2d goal = Eigen::Vector2d::Zero();
  Eigen::Vector2d initial = Eigen::Vector2d::Zero();
  ActionCost action_cost = {};
  bool on_target = false;  // the cube is on the target
  bool reached = false;    // it has been there
  bool success = false;
  double cube_halfsize = 0.02;  // m
  SmoothnessParams smoothness = {
      .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.08, .QVEL_L2_COEF = 0.01};
  TakeItBackShaping shaping = {};
  bool lists_smoothness = true;  // in reward_dict
  // Terms.
  double push_distance = 0;  // TCP to the point from which to push, m
  double pull_distance = 0;
  double reaching_push = 0;
  double reaching_pull = 0;
  double contact = 0;
  double in_goal = 0;
  double back = 0;
  bool at_push_point = false;
  bool at_pull_point = false;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reached_push", "", at_push_point);
    row.term("reached_pull", "", at_pull_point);
    row.term("tcp_push_dist", "m", push_distance);
    row.term("tcp_pull_dist", "m", pull_distance);
    row.term("reaching_reward_push", "", reaching_push);
    row.term("reaching_reward_pull", "", reaching_pull);
    if (shaping.contact_weight > 0) row.term("keep_contact_reward", "", contact);
    row.term("goal_achieved", "", on_target);
    row.term("goal_reached_status", "", reached);
    row.term("place_in_goal_reward", "", in_goal);
    row.term("place_back_reward", "", back);
    if (lists_smoothness) smooth.list_terms(row);
  }
};

extern const Family kTakeItBack;

}  // namespace engram::tasks
