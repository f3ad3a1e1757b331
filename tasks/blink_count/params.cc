#include "tasks/blink_count/params.h"

#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/join.h"
#include "tasks/blink_count/reward.h"
#include "tasks/common/lamp.h"

namespace engram::tasks {
namespace {

std::vector<RandomVariable> draws_of(const BlinkCountParams& params) {
  const int most = params.BLINK_COUNT_RANGE.high;
  const auto steps = [](const char* name, int width, StepRange range, const char* what,
                        const char* constant) {
    RandomVariable draw = range.draw(name, what, constant);
    draw.width = width;
    return draw;
  };
  return {
      {"target_blinks", 1, true, static_cast<double>(params.BLINK_COUNT_RANGE.low),
       static_cast<double>(most), "", "blinks to count", false, "BLINK_COUNT_RANGE"},
      {"button_x", 1, false, kButtonX[0], kButtonX[1], "m", "place of the red button"},
      {"button_y", 1, false, kButtonY[0], kButtonY[1], "m", "place of the red button"},
      steps("pre_blink_off_steps", 1, params.PRE_BLINK_OFF_STEPS, "before the first blink",
            "PRE_BLINK_OFF_STEPS"),
      steps("blink_on_steps", most, params.BLINK_ON_STEPS, "length of every blink",
            "BLINK_ON_STEPS"),
      steps("blink_off_steps", most, params.BLINK_OFF_STEPS, "darkness after every blink",
            "BLINK_OFF_STEPS"),
  };
}

Constant color_constant(const mjcf::Rgba& rgba) {
  return ConstantList{rgba[0], rgba[1], rgba[2], rgba[3]};
}

ConstantTable constants_of(const BlinkCountParams& params) {
  ConstantTable table = {
      {"BLINK_COUNT_RANGE", params.BLINK_COUNT_RANGE.constant()},
      {"PRE_BLINK_OFF_STEPS", params.PRE_BLINK_OFF_STEPS.constant()},
      {"BLINK_ON_STEPS", params.BLINK_ON_STEPS.constant()},
      {"BLINK_OFF_STEPS", params.BLINK_OFF_STEPS.constant()},
      {"CONFIRM_BUTTON_Y_OFFSET", CONFIRM_BUTTON_Y_OFFSET},
  };
  add_lamp_constants(table);
  const ConstantTable more = {
      {"INDICATOR_FORWARD_OFFSET", INDICATOR_FORWARD_OFFSET},
      {"PHASE_INDICATOR_X_OFFSET", PHASE_INDICATOR_X_OFFSET},
      {"INDICATOR_HEIGHT", INDICATOR_HEIGHT},
      {"HEIGHT_OFFSET", 1000.0},
      {"DEFAULT_BLINK_COLOR", color_constant({0, 0, 1, 1})},
      {"PHASE_WAIT_COLOR", color_constant(PHASE_WAIT_COLOR)},
      {"PHASE_READY_COLOR", color_constant(PHASE_READY_COLOR)},
      {"ACTION_L2_COEF", params.smoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", params.smoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", params.smoothness.QVEL_L2_COEF},
      {"SUCCESS_BONUS", SUCCESS_BONUS},
      {"FAILURE_PENALTY", FAILURE_PENALTY},
  };
  table.insert(table.end(), more.begin(), more.end());
  add_constants(params.button, table);
  return table;
}

std::vector<TaskOptionSpec> options() {
  const auto component = [](const char* name, double value) {
    return TaskOptionSpec{name,
                          value,
                          false,
                          0,
                          255,
                          "",
                          "colour of the blinking lamp; 0 to 1, or 0 to 255 if one is above 1"};
  };
  return {component("blink_red", 0), component("blink_green", 0), component("blink_blue", 1)};
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

// --- what users may change ---

void BlinkCountParams::constants(Changes& list) {
  constexpr double kLongest = 1000;  // control steps
  list.integer_range("BLINK_COUNT_RANGE", BLINK_COUNT_RANGE.low, BLINK_COUNT_RANGE.high, {1, 100},
                     "", "blinks to count");
  list.steps("PRE_BLINK_OFF_STEPS", PRE_BLINK_OFF_STEPS, {0, kLongest},
             "darkness before the first blink");
  list.steps("BLINK_ON_STEPS", BLINK_ON_STEPS, {1, kLongest}, "how long a blink is");
  list.steps("BLINK_OFF_STEPS", BLINK_OFF_STEPS, {1, kLongest}, "darkness after every blink");
  button.constants(list);
  list.real("REQUIRED_LIFT_HEIGHT", button.REQUIRED_LIFT_HEIGHT, {0.02, 0.3}, "m",
            "how far above the height of a press the tool has to rise until it counts");
  smoothness.constants(list);
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
  check_time(horizon,
             {{"PRE_BLINK_OFF_STEPS", PRE_BLINK_OFF_STEPS.high},
              {(blinks + " =").c_str(), most * (BLINK_ON_STEPS.high + BLINK_OFF_STEPS.high)}},
             steps_per_press() * (most + 1));
}

void describe_blink_count(const BlinkCountParams& params, TaskInfo& info) {
  info.candidates = params.BLINK_COUNT_RANGE.high - params.BLINK_COUNT_RANGE.low + 1;
  info.answer =
      "the number of presses when the black button is pressed for the first time, or when there is "
      "one too many; that number";
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = SUCCESS_BONUS;
  info.oracle_dim = 1;
  info.random_variables = draws_of(params);
  info.hidden_variable = "target_blinks";
  info.options = options();
  info.constants = constants_of(params);
  info.phases = {{"cue", "elapsed < C: the lamp blinks; presses do not count"},
                 {"action", "elapsed >= C: the phase lamp is green"}};
}

}  // namespace engram::tasks
