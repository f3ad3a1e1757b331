#include "tasks/common/touch_target.h"

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

template <class Visitor>
void list_terms(Visitor& row, bool action_cost, const TouchRewardInputs& in,
                const TouchRewardTerms& terms) {
  row.term("tcp_to_obj_dist", "m", in.distance);
  row.term("reaching_reward", "", terms.reaching);
  row.term("is_robot_static", "", in.robot_static);
  row.term("reached", "", in.distance < in.goal_thresh);
  row.term("success", "", in.success);
  row.term("static_reward", "", terms.stillness);
  if (action_cost) {
    list_smoothness(row, terms.smooth);
    row.term("smooth_penalty", "", terms.smooth.penalty);
  }
  row.term("obj_to_goal_pos_y", "m", in.offset_y);
  row.term("obj_to_goal_pos_x", "m", in.offset_x);
}

}  // namespace

TouchRewardTerms touch_reward(const TouchRewardInputs& in, const SmoothnessParams& params) {
  TouchRewardTerms terms;
  terms.reaching = 1 - real::tanh(10 * in.distance);
  terms.stillness = 1 - real::tanh(5 * in.arm_speed);
  terms.smooth = smoothness({in.action_norm, in.action_delta_norm, in.arm_speed}, params);
  const double bonus = in.robot_static && in.placed ? 0.5 : 0.0;
  terms.reward = in.success ? kTouchSuccessReward
                            : terms.reaching + 0.5 * terms.stillness + bonus - terms.smooth.penalty;
  return terms;
}

std::vector<Field> TouchTarget::reward_terms() const {
  return reward_terms_of([&](auto& row) { list_terms(row, smoothness_.has_value(), {}, {}); });
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

double TouchTarget::dense_reward(int env) const {
  const ActionCost cost = measure_action_cost(engine_, env);
  TouchRewardInputs in;
  const double* offset = offset_.row(env);
  in.distance = Eigen::Map<const Eigen::Vector3d>(offset).norm();
  in.goal_thresh = goal_thresh_;
  in.offset_x = offset[0];
  in.offset_y = offset[1];
  in.arm_speed = cost.arm_speed;
  in.action_norm = cost.action_norm;
  in.action_delta_norm = cost.action_delta_norm;
  in.robot_static = is_robot_static_[env] != 0;
  in.placed = is_obj_placed_[env] != 0;
  in.success = engine_.success[env] != 0;
  const TouchRewardTerms terms = touch_reward(in, smoothness_.value_or(SmoothnessParams{}));
  reward_dict_.note(env, [&](auto& row) { list_terms(row, smoothness_.has_value(), in, terms); });
  return terms.reward;
}

}  // namespace engram::tasks
