// Time window and dense reward of TimedTransfer.
#pragma once

#include "tasks/common/action_cost.h"

namespace engram::tasks {

inline constexpr double TOLERANCE_FRAC = 0.05;  // unless a user changes it
inline constexpr double kTimedTransferSuccessReward = 30;
inline constexpr double FAILURE_PENALTY = 25;
inline constexpr SmoothnessParams kTimedTransferSmoothness = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

// Values of elapsed, both ends included, in which the cube has to arrive.
struct TimeWindow {
  int start = 0;
  int end = 0;
};
// Rounding of a window whose tolerance is no whole number of steps.
enum class WindowRounding {
  kInward,  // the steps within the tolerance
  kDown,    // both ends: the first step may come before the tolerance
};
TimeWindow time_window(int signal_step, int delay_steps, double tolerance = TOLERANCE_FRAC,
                       WindowRounding rounding = WindowRounding::kInward);

// Position of a step in the count.
struct CountPhase {
  bool signal_on = false;
  bool before_window = false;  // since the signal
  bool in_window = false;
  bool past_window = false;
};
CountPhase count_phase(int elapsed, int signal_step, const TimeWindow& window);

// Dense reward (tasks/common/reward_dict.h).
struct TransferReward {
  double tcp_to_cube = 0;   // m
  double cube_to_goal = 0;  // m
  ActionCost action_cost = {};
  CountPhase count = {};
  bool grasped = false;
  bool on_red = false;
  bool success = false;
  bool failed = false;
  SmoothnessParams smoothness = kTimedTransferSmoothness;
  // Terms.
  double reaching = 0;
  double place = 0;
  double stillness = 0;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("place_reward", "", place);
    row.term("is_grasped", "", grasped);
    row.term("tcp_to_cube_dist", "m", tcp_to_cube);
    row.term("obj_to_goal_dist", "m", cube_to_goal);
    row.term("cube_on_red", "", on_red);
    row.term("static_reward", "", stillness);
    row.term("smooth_penalty", "", smooth.penalty);
    smooth.list_parts(row);
  }
};

}  // namespace engram::tasks
