// Penalty on large and abrupt actions, which dense rewards subtract.
#pragma once

#include "core/task/task.h"
#include "tasks/common/constant_binder.h"

namespace engram::tasks {

// Weights of the smoothness penalty, named as the class constants.
struct SmoothnessParams {
  double ACTION_L2_COEF = 0;
  double ACTION_DELTA_L2_COEF = 0;
  double QVEL_L2_COEF = 0;

  void declare(ConstantBinder& constants);
};

// Norms that the penalty weighs.
struct ActionCost {
  double action_norm = 0;        // of the action as received
  double action_delta_norm = 0;  // of its change
  double arm_speed = 0;          // norm of the arm joint velocities, rad/s
};

// The action before the first one of an episode: none, so that the first is no change, or zeros.
enum class FirstChange { kNone, kFromZero };

ActionCost measure_action_cost(const Bindings& engine, int env,
                               FirstChange first = FirstChange::kNone);

struct SmoothnessTerms {
  double action_l2 = 0;
  double action_delta_l2 = 0;
  double qvel_l2 = 0;
  double penalty = 0;
};

// Parts of the penalty, as terms of the reward; "smooth_penalty" itself stands apart, where each
// family has it.
template <class Visitor>
void list_smoothness(Visitor& row, const SmoothnessTerms& terms) {
  row.term("action_l2", "", terms.action_l2);
  row.term("delta_action_l2", "", terms.action_delta_l2);
  row.term("qvel_l2", "", terms.qvel_l2);
}

SmoothnessTerms smoothness(const ActionCost& cost, const SmoothnessParams& params);
// The penalty; nothing is computed where it weighs nothing.
double smoothness_penalty(const Bindings& engine, int env, const SmoothnessParams& params);

}  // namespace engram::tasks
