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

// Terms of a reward (tasks/common/reward_dict.h).
struct SmoothnessTerms {
  double action_l2 = 0;
  double action_delta_l2 = 0;
  double qvel_l2 = 0;
  double penalty = 0;

  template <class Visitor>
  void list_parts(Visitor& row) const {
    row.term("action_l2", "", action_l2);
    row.term("delta_action_l2", "", action_delta_l2);
    row.term("qvel_l2", "", qvel_l2);
  }
  template <class Visitor>
  void list_terms(Visitor& row) const {
    list_parts(row);
    row.term("smooth_penalty", "", penalty);
  }
};

SmoothnessTerms smoothness(const ActionCost& cost, const SmoothnessParams& params);
// The penalty; nothing is computed where it weighs nothing.
double smoothness_penalty(const Bindings& engine, int env, const SmoothnessParams& params);

}  // namespace engram::tasks
