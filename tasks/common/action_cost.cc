#include "tasks/common/action_cost.h"

#include "core/math/float_sums.h"
#include "core/math/real_functions.h"

namespace engram::tasks {

void SmoothnessParams::declare(ConstantBinder& constants) {
  constexpr Bounds kWeight{0, 10};
  constants.real("ACTION_L2_COEF", ACTION_L2_COEF, kWeight, "",
                 "penalty on the size of actions in dense rewards");
  constants.real("ACTION_DELTA_L2_COEF", ACTION_DELTA_L2_COEF, kWeight, "",
                 "penalty on changes of the action in dense rewards");
  constants.real("QVEL_L2_COEF", QVEL_L2_COEF, kWeight, "s/rad",
                 "penalty on the speed of the arm's joints in dense rewards");
}

ActionCost measure_action_cost(const Bindings& engine, int env, FirstChange first) {
  const State& state = *engine.state;
  const int dim = engine.action.width();
  const float* action = engine.action.row(env);
  const float* previous = engine.previous_action.row(env);
  ActionCost cost;
  cost.action_norm = static_cast<double>(length_of(dim, [&](int i) { return action[i]; }));
  if (state.elapsed[env] > 1 || first == FirstChange::kFromZero) {
    cost.action_delta_norm =
        static_cast<double>(length_of(dim, [&](int i) { return action[i] - previous[i]; }));
  }
  cost.arm_speed = Eigen::Map<const ArmVector>(state.qvel.row(env)).norm();
  return cost;
}

SmoothnessTerms smoothness(const ActionCost& cost, const SmoothnessParams& params) {
  SmoothnessTerms terms;
  terms.action_l2 = real::tanh(2 * cost.action_norm);
  terms.action_delta_l2 = real::tanh(5 * cost.action_delta_norm);
  terms.qvel_l2 = real::tanh(2 * cost.arm_speed);
  terms.penalty = params.ACTION_L2_COEF * terms.action_l2 +
                  params.ACTION_DELTA_L2_COEF * terms.action_delta_l2 +
                  params.QVEL_L2_COEF * terms.qvel_l2;
  return terms;
}

double smoothness_penalty(const Bindings& engine, int env, const SmoothnessParams& params) {
  const bool free =
      params.ACTION_L2_COEF == 0 && params.ACTION_DELTA_L2_COEF == 0 && params.QVEL_L2_COEF == 0;
  return free ? 0.0 : smoothness(measure_action_cost(engine, env), params).penalty;
}

}  // namespace engram::tasks
