#include "tasks/blink_count/params.h"

#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/join.h"
#include "tasks/common/lamp.h"
#include "tasks/common/phase_budget.h"

namespace engram::tasks {
namespace {

Constant color_constant(const mjcf::Rgba& rgba) {
  return ConstantList{rgba[0], rgba[1], rgba[2], rgba[3]};
}

// Throws Error unless the two buttons stand apart, and no place is over both.
void check_apart(const PressButtonParams& button) {
  const auto require = [](const char* name, double value) {
    if (2 * value <= CONFIRM_BUTTON_Y_OFFSET) return;
    refuse_constant(name, shortest(value),
                    "at most half of the " + shortest(CONFIRM_BUTTON_Y_OFFSET) +
                        " m between the two buttons allowed");
  };
  require("BUTTON_BASE_HALF_SIZE", button.shape.BUTTON_BASE_HALF_SIZE[1]);
  require("BUTTON_PRESS_XY_RADIUS", button.BUTTON_PRESS_XY_RADIUS);
}

}  // namespace

// --- constants ---

void BlinkCountParams::declare(ConstantBinder& constants) {
  constexpr double kLongest = 1000;  // control steps
  constants.range("BLINK_COUNT_RANGE", BLINK_COUNT_RANGE, {1, 100}, "", "blinks to count",
                  {"target_blinks", "blinks to count"});
  constants.steps("PRE_BLINK_OFF_STEPS", PRE_BLINK_OFF_STEPS, {0, kLongest},
                  "darkness before the first blink",
                  {"pre_blink_off_steps", "before the first blink"});
  constants.steps("BLINK_ON_STEPS", BLINK_ON_STEPS, {1, kLongest}, "how long a blink is",
                  {"blink_on_steps", "length of every blink"});
  constants.steps("BLINK_OFF_STEPS", BLINK_OFF_STEPS, {1, kLongest}, "darkness after every blink",
                  {"blink_off_steps", "darkness after every blink"});
  constants.fixed({{"CONFIRM_BUTTON_Y_OFFSET", CONFIRM_BUTTON_Y_OFFSET}});
  declare_lamp(constants);
  constants.fixed({{"INDICATOR_FORWARD_OFFSET", INDICATOR_FORWARD_OFFSET},
                   {"PHASE_INDICATOR_X_OFFSET", PHASE_INDICATOR_X_OFFSET},
                   {"INDICATOR_HEIGHT", INDICATOR_HEIGHT},
                   {"HEIGHT_OFFSET", 1000.0},
                   {"DEFAULT_BLINK_COLOR", color_constant({0, 0, 1, 1})},
                   {"PHASE_WAIT_COLOR", color_constant(PHASE_WAIT_COLOR)},
                   {"PHASE_READY_COLOR", color_constant(PHASE_READY_COLOR)},
                   {"SUCCESS_BONUS", SUCCESS_BONUS},
                   {"FAILURE_PENALTY", FAILURE_PENALTY}});
  button.declare(constants);
  button.declare_lift(constants);
  smoothness.declare(constants);
}

int BlinkCountParams::steps_per_press() const {
  return static_cast<int>(std::lround(8 + 30 * button.REQUIRED_LIFT_HEIGHT));
}

void BlinkCountParams::check(int horizon) const {
  button.check();
  check_apart(button);
  const int most = BLINK_COUNT_RANGE.high;
  const std::string blinks = std::to_string(most) + " x (BLINK_ON_STEPS " +
                             std::to_string(BLINK_ON_STEPS.high) + " + BLINK_OFF_STEPS " +
                             std::to_string(BLINK_OFF_STEPS.high) + ")";
  check_horizon(horizon,
                {{"PRE_BLINK_OFF_STEPS", PRE_BLINK_OFF_STEPS.high},
                 {(blinks + " =").c_str(), most * (BLINK_ON_STEPS.high + BLINK_OFF_STEPS.high)}},
                steps_per_press() * (most + 1));
}

BlinkVariables::BlinkVariables(RandomVariables list, const BlinkCountParams& params)
    : target_blinks(list.of(params.BLINK_COUNT_RANGE)),
      button_x(list.real("button_x", {-0.15, -0.05}, "m", "place of the red button")),
      button_y(list.real("button_y", {-0.12, 0.12}, "m", "place of the red button")),
      pre_steps(list.of(params.PRE_BLINK_OFF_STEPS)),
      on_steps(list.of(params.BLINK_ON_STEPS, params.BLINK_COUNT_RANGE.high)),
      off_steps(list.of(params.BLINK_OFF_STEPS, params.BLINK_COUNT_RANGE.high)) {}

BlinkOptions::BlinkOptions(TaskOptions list) {
  const auto component = [&list](const char* name, double value) {
    return list.add({name, value, false, 0, 255, "",
                     "colour of the blinking lamp; 0 to 1, or 0 to 255 if one is above 1"});
  };
  red = component("blink_red", 0);
  green = component("blink_green", 0);
  blue = component("blink_blue", 1);
}

void describe_blink_count(const BlinkCountParams& params, TaskInfo& info) {
  info.candidates = params.BLINK_COUNT_RANGE.high - params.BLINK_COUNT_RANGE.low + 1;
  info.answer =
      "the number of presses when the black button is pressed for the first time, or when there is "
      "one too many; that number";
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = SUCCESS_BONUS;
  info.oracle_dim = 1;
  info.hidden_variable = "target_blinks";
  info.phases = {{"cue", "elapsed < C: the lamp blinks; presses do not count"},
                 {"action", "elapsed >= C: the phase lamp is green"}};
}

}  // namespace engram::tasks
