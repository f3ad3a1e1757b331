// RotateLenient and RotateStrict: turn the peg by the angle of the instruction; the strict one
// keeps its centre in place (docs/tasks/rotate.md).
#pragma once

#include <cmath>
#include <numbers>

#include "tasks/common/action_cost.h"
#include "tasks/family.h"

namespace engram::tasks {

// Names of reward terms, which the original spells in several ways.
struct RotateTermNames {
  const char* correct_angle = "correct_angle";
  const char* angle_diff = "angle_diff_deg";
};

// Dense reward (tasks/common/reward_dict.h).
struct RotateReward {
  double distance = 0;     // peg centre to TCP, m
  double error = 0;        // rad
  double x_pos_error = 0;  // m, of the peg's centre (strict)
  double y_pos_error = 0;
  ActionCost action_cost = {};
  bool robot_static = false;
  bool success = false;
  double angle_threshold = 0.1;  // rad
  SmoothnessParams smoothness = {};
  double success_reward = 0;  // at success, instead of all terms
  bool strict = false;
  RotateTermNames names = {};
  bool lists_smoothness = true;  // in reward_dict
  // Terms.
  double reaching = 0;
  bool reached = false;
  double rotate = 0;
  double x_pos = 0;
  double y_pos = 0;
  bool position_ok = false;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("to_grip_dist", "m", distance);
    row.term("reaching_reward", "", reaching);
    row.term("reached_status", "", reached);
    row.term("y_angle_reward", "", rotate);
    row.term(names.correct_angle, "", is_correct());
    row.term(names.angle_diff, "deg", error * 180 / std::numbers::pi);
    row.term("agent_is_static", "", robot_static);
    row.term("success", "", success);
    if (strict) {
      row.term("x_pos_error", "m", x_pos_error);
      row.term("y_pos_error", "m", y_pos_error);
      row.term("x_pos_reward", "", x_pos);
      row.term("y_pos_reward", "", y_pos);
      row.term("position_ok", "", position_ok);
    }
    if (lists_smoothness) smooth.list_terms(row);
  }

 private:
  bool is_correct() const { return std::abs(error) < angle_threshold; }
  double lenient_value();
  double strict_value();
};

extern const Family kRotateLenient;
extern const Family kRotateStrict;

}  // namespace engram::tasks
