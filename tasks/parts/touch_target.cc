#include "tasks/parts/touch_target.h"

#include <array>
#include <cmath>

namespace engram::tasks {

TouchRewardTerms touch_reward(const TouchRewardInputs& in, const SmoothnessParams& params) {
  TouchRewardTerms terms;
  terms.reaching = 1 - std::tanh(10 * in.distance);
  terms.stillness = 1 - std::tanh(5 * in.arm_speed);
  const SmoothnessTerms smooth =
      smoothness({in.action_norm, in.action_delta_norm, in.arm_speed}, params);
  terms.action_l2 = smooth.action_l2;
  terms.action_delta_l2 = smooth.action_delta_l2;
  terms.qvel_l2 = smooth.qvel_l2;
  terms.penalty = smooth.penalty;
  const double bonus = in.robot_static && in.placed ? 0.5 : 0.0;
  terms.reward = in.success ? kTouchSuccessReward
                            : terms.reaching + 0.5 * terms.stillness + bonus - terms.penalty;
  return terms;
}

std::vector<std::string> TouchTarget::reward_term_names() {
  return {"tcp_to_obj_dist", "reaching_reward", "is_robot_static",   "reached",
          "success",         "static_reward",   "action_l2",         "delta_action_l2",
          "qvel_l2",         "smooth_penalty",  "obj_to_goal_pos_y", "obj_to_goal_pos_x"};
}

void TouchTarget::bind(const Bindings& bindings) {
  engine_ = bindings;
  ColumnStore& info = *bindings.outputs;
  obj_to_goal_pos_ =
      info.add<float>("obj_to_goal_pos", 3, "m", "target position minus TCP position");
  is_obj_placed_ = info.add<std::uint8_t>("is_obj_placed", 1, "", "TCP within GOAL_THRESH");
  is_robot_static_ = info.add<std::uint8_t>("is_robot_static");
  offset_ = bindings.memory->add<double>("obj_to_goal_pos", 3, "m");
  reward_dict_.bind(bindings, kRewardTerms);
}

void TouchTarget::evaluate(int env, const double* target_pos, bool acting) const {
  const State& state = *engine_.state;
  double* offset = offset_.row(env);
  for (int i = 0; i < 3; ++i) {
    offset[i] = target_pos[i] - state.tcp_pos.row(env)[i];
    obj_to_goal_pos_.row(env)[i] = static_cast<float>(offset[i]);
  }
  const bool placed = Eigen::Map<const Eigen::Vector3d>(offset).norm() <= GOAL_THRESH;
  const bool still = robot_is_static(state, env);
  is_obj_placed_[env] = placed ? 1 : 0;
  is_robot_static_[env] = still ? 1 : 0;
  engine_.success[env] = placed && still && acting ? 1 : 0;
  reward_dict_.publish(env);
}

double TouchTarget::dense_reward(int env) const {
  const Haste haste = measure_haste(engine_, env);
  TouchRewardInputs in;
  const double* offset = offset_.row(env);
  in.distance = Eigen::Map<const Eigen::Vector3d>(offset).norm();
  in.arm_speed = haste.arm_speed;
  in.action_norm = haste.action_norm;
  in.action_delta_norm = haste.action_delta_norm;
  in.robot_static = is_robot_static_[env] != 0;
  in.placed = is_obj_placed_[env] != 0;
  in.success = engine_.success[env] != 0;
  const TouchRewardTerms terms = touch_reward(in, params_);

  const std::array<double, kRewardTerms> row = {in.distance,
                                                terms.reaching,
                                                in.robot_static ? 1.0 : 0.0,
                                                in.distance < GOAL_THRESH ? 1.0 : 0.0,
                                                in.success ? 1.0 : 0.0,
                                                terms.stillness,
                                                terms.action_l2,
                                                terms.action_delta_l2,
                                                terms.qvel_l2,
                                                terms.penalty,
                                                offset[1],
                                                offset[0]};
  reward_dict_.note(env, row);
  return terms.reward;
}

}  // namespace engram::tasks
