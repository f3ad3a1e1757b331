// ShellGamePick of the RL half: the mug that hides the ball has to come to a goal above its slot,
// however that is done. The reward leads the tool to the mug's origin and knows no handle.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/task/task.h"
#include "tasks/registry.h"

namespace engram::tasks {

// Dense reward (tasks/common/reward_dict.h): 0 outside the manipulation phase, 75 at success.
struct MugPickReward {
  double to_goal = 0;    // mug to the goal's centre, m
  double arm_speed = 0;  // rad/s
  bool robot_static = false;
  bool placed = false;
  bool manipulation = false;
  bool success = false;
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // TCP to the mug's origin, m
  bool grasped = false;                              // for reward_dict alone
  // Terms.
  double reaching = 0;
  double place = 0;
  double stillness = 0;
  bool reached = false;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("reached_status", "", reached);
    row.term("info[\"is_grasped\"]", "", grasped);
    row.term("place_reward", "", place);
    row.term("static_reward", "", stillness);
    row.term("tcp_to_obj_dist", "m", offset.norm());
    row.term("obj_to_goal_dist", "m", to_goal);
    row.term("info[\"is_obj_placed\"]", "", placed);
    row.term("dx", "m", offset.x());
    row.term("dy", "m", offset.y());
    row.term("dz", "m", offset.z());
  }
};

// Makes ShellGamePick-v0.
std::unique_ptr<Task> make_mug_pick(const RegistryEntry& entry, const ConstantTable& constants);

}  // namespace engram::tasks
