#include "tasks/common/touch_target.h"

#include "core/math/real_functions.h"

namespace engram::tasks {

double TouchReward::compute() {
  reaching = 1 - real::tanh(10 * distance);
  stillness = 1 - real::tanh(5 * arm_speed);
  smooth = tasks::smoothness({action_norm, action_delta_norm, arm_speed},
                             smoothness.value_or(SmoothnessParams{}));
  const double bonus = robot_static && placed ? 0.5 : 0.0;
  return success ? kTouchSuccessReward : reaching + 0.5 * stillness + bonus - smooth.penalty;
}

void TouchTarget::bind(const Bindings& bindings) {
  engine_ = bindings;
  ColumnStore& info = *bindings.outputs;
  obj_to_goal_pos_ =
      info.add_privileged<float>("obj_to_goal_pos", 3, "m", "target position minus TCP position");
  is_obj_placed_ =
      info.add_privileged<std::uint8_t>("is_obj_placed", 1, "", "TCP within GOAL_THRESH");
  is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
  offset_ = bindings.memory->add<double>("obj_to_goal_pos", 3, "m");
  reward_dict_.bind(bindings, reward_terms().size());
}

void TouchTarget::evaluate(int env, const double* target_pos, bool acting) const {
  const State& state = *engine_.state;
  double* offset = offset_.row(env);
  for (int i = 0; i < 3; ++i) {
    offset[i] = target_pos[i] - state.tcp_pos.row(env)[i];
    obj_to_goal_pos_.row(env)[i] = static_cast<float>(offset[i]);
  }
  const bool placed = Eigen::Map<const Eigen::Vector3d>(offset).norm() <= goal_thresh_;
  const bool still = robot_is_static(state, env);
  is_obj_placed_[env] = placed ? 1 : 0;
  is_robot_static_[env] = still ? 1 : 0;
  engine_.success[env] = placed && (still || !static_needed_) && acting ? 1 : 0;
  reward_dict_.publish(env);
}

TouchReward TouchTarget::measure(int env) const {
  const ActionCost cost = measure_action_cost(engine_, env);
  const double* offset = offset_.row(env);
  return {.distance = Eigen::Map<const Eigen::Vector3d>(offset).norm(),
          .arm_speed = cost.arm_speed,
          .action_norm = cost.action_norm,
          .action_delta_norm = cost.action_delta_norm,
          .robot_static = is_robot_static_[env] != 0,
          .placed = is_obj_placed_[env] != 0,
          .success = engine_.success[env] != 0,
          .offset_x = offset[0],
          .offset_y = offset[1],
          .goal_thresh = goal_thresh_,
          .smoothness = smoothness_};
}

}  // namespace engram::tasks
