// The dense reward of BlinkCountButtonPress (buttons 6.9).
#pragma once

#include <array>
#include <string>
#include <vector>

#include "tasks/parts/press_button.h"
#include "tasks/parts/smoothness.h"

namespace engram::tasks {

inline constexpr double SUCCESS_BONUS = 30.0;
inline constexpr double FAILURE_PENALTY = 25.0;
inline constexpr SmoothnessParams kBlinkSmoothness = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

// Everything after the evaluation of the step.
struct BlinkRewardInputs {
  double height = 0;              // of the TCP, m
  double xy_distance = 0;         // to the red button, m
  double cap_distance = 0;        // from the TCP to the red cap, m
  double black_cap_distance = 0;  // and to the black one
  double depth = 0;               // of the red button, m
  double black_depth = 0;
  int press_count = 0;
  int target = 1;
  bool pending = false;     // a press of the red button waits for its lift
  double start_height = 0;  // of that press, m
  PressEvents red;          // what happened in this step
  bool submitted = false;
  bool acting = false;
  bool failed = false;
  bool success = false;
  Haste haste;
};

inline constexpr std::size_t kBlinkRewardTerms = 37;

struct BlinkReward {
  double reward = 0;
  std::array<double, kBlinkRewardTerms> terms{};  // in the order of blink_reward_term_names
};

BlinkReward blink_reward(const BlinkRewardInputs& inputs, const PressButtonParams& button);

std::vector<std::string> blink_reward_term_names();

}  // namespace engram::tasks
