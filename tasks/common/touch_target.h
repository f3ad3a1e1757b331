// Success, info and reward of the families in which the robot touches the right object: bring the
// TCP within GOAL_THRESH of its origin and, unless the family says otherwise, stand still
// (docs/tasks/remember.md).
#pragma once

#include <optional>
#include <vector>

#include "core/task/task.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/reward_dict.h"

namespace engram::tasks {

inline constexpr double GOAL_THRESH = 0.05;         // m, unless a user changes it
inline constexpr double kTouchSuccessReward = 3.0;  // dense reward of a success step

// Dense reward (tasks/common/reward_dict.h).
struct TouchReward {
  double distance = 0;           // TCP to target, m
  double arm_speed = 0;          // norm of the arm joint velocities, rad/s
  double action_norm = 0;        // of the action as received
  double action_delta_norm = 0;  // of its change; taken as 0 up to elapsed = 1
  bool robot_static = false;
  bool placed = false;
  bool success = false;
  double offset_x = 0;  // TCP to target along each axis, m; for reward_dict alone
  double offset_y = 0;
  double goal_thresh = 0;  // m, within which reward_dict says that it is reached
  // Weights of the action cost; none: the reward knows no such cost.
  std::optional<SmoothnessParams> smoothness = {};
  // Terms.
  double reaching = 0;
  double stillness = 0;
  SmoothnessTerms smooth = {};

  // A success step is worth exactly 3.
  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("tcp_to_obj_dist", "m", distance);
    row.term("reaching_reward", "", reaching);
    row.term("is_robot_static", "", robot_static);
    row.term("reached", "", distance < goal_thresh);
    row.term("success", "", success);
    row.term("static_reward", "", stillness);
    if (smoothness) smooth.list_terms(row);
    row.term("obj_to_goal_pos_y", "m", offset_y);
    row.term("obj_to_goal_pos_x", "m", offset_x);
  }
};

class TouchTarget {
 public:
  TouchTarget(double goal_thresh, const std::optional<SmoothnessParams>& smoothness)
      : goal_thresh_(goal_thresh), smoothness_(smoothness) {}

  // The values in info "reward_dict".
  std::vector<Field> reward_terms() const {
    return reward_terms_of(TouchReward{.smoothness = smoothness_});
  }

  void bind(const Bindings& bindings);
  // Whether success needs a robot that stands still.
  void need_static(bool needed) { static_needed_ = needed; }
  bool static_needed() const { return static_needed_; }
  // `acting`: the manipulation phase has begun.
  void evaluate(int env, const double* target_pos, bool acting) const;
  void dense_reward(Range envs, FloatRows out) const {
    reward_dict_.write(envs, out, [&](int env) { return measure(env); });
  }

 private:
  TouchReward measure(int env) const;

  double goal_thresh_;  // m
  std::optional<SmoothnessParams> smoothness_;
  bool static_needed_ = true;
  Bindings engine_;
  Column<float> obj_to_goal_pos_;  // (3) m
  Column<std::uint8_t> is_obj_placed_;
  Column<std::uint8_t> is_robot_static_;
  RewardDict reward_dict_;
  Column<double> offset_;  // (3) obj_to_goal_pos in full precision
};

}  // namespace engram::tasks
