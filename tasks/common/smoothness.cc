#include "tasks/common/smoothness.h"

#include "core/math/float_sums.h"
#include "core/math/real_functions.h"
#include "tasks/common/task_info.h"

namespace engram::tasks {

void SmoothnessParams::constants(Changes& list) {
  constexpr Bounds kWeight{0, 10};
  list.real("ACTION_L2_COEF", ACTION_L2_COEF, kWeight, "",
            "penalty on the size of actions in dense rewards");
  list.real("ACTION_DELTA_L2_COEF", ACTION_DELTA_L2_COEF, kWeight, "",
            "penalty on changes of the action in dense rewards");
  list.real("QVEL_L2_COEF", QVEL_L2_COEF, kWeight, "s/rad",
            "penalty on the speed of the arm's joints in dense rewards");
}

Haste measure_haste(const Bindings& engine, int env, FirstChange first) {
  const State& state = *engine.state;
  const int dim = engine.action.width();
  const float* action = engine.action.row(env);
  const float* previous = engine.previous_action.row(env);
  Haste haste;
  haste.action_norm = static_cast<double>(length_of(dim, [&](int i) { return action[i]; }));
  if (state.elapsed[env] > 1 || first == FirstChange::kFromZero) {
    haste.action_delta_norm =
        static_cast<double>(length_of(dim, [&](int i) { return action[i] - previous[i]; }));
  }
  haste.arm_speed = Eigen::Map<const ArmVector>(state.qvel.row(env)).norm();
  return haste;
}

void add_constants(const SmoothnessParams& params, ConstantTable& table) {
  append(table, {{"ACTION_L2_COEF", params.ACTION_L2_COEF},
                 {"ACTION_DELTA_L2_COEF", params.ACTION_DELTA_L2_COEF},
                 {"QVEL_L2_COEF", params.QVEL_L2_COEF}});
}

SmoothnessTerms smoothness(const Haste& haste, const SmoothnessParams& params) {
  SmoothnessTerms terms;
  terms.action_l2 = real::tanh(2 * haste.action_norm);
  terms.action_delta_l2 = real::tanh(5 * haste.action_delta_norm);
  terms.qvel_l2 = real::tanh(2 * haste.arm_speed);
  terms.penalty = params.ACTION_L2_COEF * terms.action_l2 +
                  params.ACTION_DELTA_L2_COEF * terms.action_delta_l2 +
                  params.QVEL_L2_COEF * terms.qvel_l2;
  return terms;
}

}  // namespace engram::tasks
