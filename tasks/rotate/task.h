// RotateLenient and RotateStrict: turn the peg by the angle of the instruction; the strict one
// keeps its centre in place (docs/tasks/rotate.md).
#pragma once

#include "tasks/common/action_cost.h"
#include "tasks/family.h"

namespace engram::tasks {

// Inputs of the dense rewards.
struct RotateRewardInputs {
  double distance = 0;     // peg centre to TCP, m
  double error = 0;        // rad
  double x_pos_error = 0;  // m, of the peg's centre (strict)
  double y_pos_error = 0;
  ActionCost action_cost;
  bool robot_static = false;
  bool success = false;
  double angle_threshold = 0.1;  // rad
  SmoothnessParams smoothness = {};
  double success_reward = 0;  // at success, instead of all terms
};

struct RotateRewardTerms {
  double reaching = 0;
  bool reached = false;
  double rotate = 0;
  double x_pos = 0;
  double y_pos = 0;
  bool position_ok = false;
  SmoothnessTerms smooth;
  double reward = 0;
};

RotateRewardTerms rotate_lenient_reward(const RotateRewardInputs& inputs);
RotateRewardTerms rotate_strict_reward(const RotateRewardInputs& inputs);

extern const Family kRotateLenient;
extern const Family kRotateStrict;

}  // namespace engram::tasks
