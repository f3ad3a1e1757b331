// Constants, variants and descriptions of BlinkCountButtonPress.
#pragma once

#include <array>

#include "core/task/task.h"
#include "mjcf/scene.h"
#include "tasks/common/action_cost.h"
#include "tasks/common/press_button.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/task_options.h"
#include "tasks/family.h"

namespace engram::tasks {

struct BlinkCountParams {
  TaskSpec task;
  StepRange BLINK_COUNT_RANGE;
  StepRange PRE_BLINK_OFF_STEPS;
  StepRange BLINK_ON_STEPS{3, 3};
  StepRange BLINK_OFF_STEPS{3, 5};
  PressButtonParams button = {};  // the red one; the black one differs in its colours
  SmoothnessParams smoothness = {
      .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

  // Control steps from a press to the next: strokes at full speed, with time to turn.
  int steps_per_press() const;
  // The step count by which every cue is over.
  int latest_start() const {
    return PRE_BLINK_OFF_STEPS.high +
           BLINK_COUNT_RANGE.high * (BLINK_ON_STEPS.high + BLINK_OFF_STEPS.high);
  }

  void declare(ConstantBinder& constants);
  void check(int horizon) const;
};

inline constexpr std::array<BlinkCountParams, 6> kBlinkVariants = {{
    {{"BlinkCountButtonPressEasy-VLA-v0", 150, Split::kShort}, {1, 3}, {5, 10}},
    {{"BlinkCountButtonPressEasy-Long-VLA-v0", 1200, Split::kLong}, {1, 10}, {5, 50}},
    {{"BlinkCountButtonPressMedium-VLA-v0", 200, Split::kShort}, {1, 5}, {5, 10}},
    {{"BlinkCountButtonPressMedium-Long-VLA-v0", 1200, Split::kLong}, {10, 20}, {5, 50}},
    {{"BlinkCountButtonPressHard-VLA-v0", 300, Split::kMedium}, {1, 7}, {5, 10}},
    {{"BlinkCountButtonPressHard-Long-VLA-v0", 1200, Split::kLong}, {20, 30}, {5, 50}},
}};

inline constexpr double CONFIRM_BUTTON_Y_OFFSET = 0.16;   // m
inline constexpr double INDICATOR_FORWARD_OFFSET = 0.22;  // m
inline constexpr double PHASE_INDICATOR_X_OFFSET = 0.2;   // m, towards -y despite its name
inline constexpr double INDICATOR_HEIGHT = 0;             // m
inline constexpr double SUCCESS_BONUS = 30.0;
inline constexpr double FAILURE_PENALTY = 25.0;

inline constexpr mjcf::Rgba PHASE_WAIT_COLOR = {1, 0, 0, 1};
inline constexpr mjcf::Rgba PHASE_READY_COLOR = {0, 1, 0, 1};

// Random variables of an episode.
struct BlinkVariables {
  BlinkVariables(RandomVariables list, const BlinkCountParams& params);

  IntegerVariable target_blinks;
  RealVariable button_x;
  RealVariable button_y;
  IntegerVariable pre_steps;
  IntegerVariable on_steps;   // of every blink
  IntegerVariable off_steps;  // after every blink
};

// Colour of the blinking lamp.
struct BlinkOptions {
  explicit BlinkOptions(TaskOptions list);

  TaskOption red;
  TaskOption green;
  TaskOption blue;
};

// Fills in TaskInfo, apart from what the registry knows, reward terms and state fields.
void describe_blink_count(const BlinkCountParams& params, TaskInfo& info);

}  // namespace engram::tasks
