#include "tasks/blink_count/params.h"

#include <array>

#include "tasks/blink_count/reward.h"
#include "tasks/parts/lamp.h"

namespace engram::tasks {
namespace {

std::vector<Draw> draws_of(const BlinkCountParams& params) {
  const int most = params.BLINK_COUNT_RANGE.high;
  const auto steps = [](const char* name, int width, StepRange range, const char* what) {
    return Draw{name,
                width,
                true,
                static_cast<double>(range.low),
                static_cast<double>(range.high),
                "control steps",
                what};
  };
  return {
      {"target_blinks", 1, true, static_cast<double>(params.BLINK_COUNT_RANGE.low),
       static_cast<double>(most), "", "blinks to count"},
      {"button_x", 1, false, kButtonX[0], kButtonX[1], "m", "place of the red button"},
      {"button_y", 1, false, kButtonY[0], kButtonY[1], "m", "place of the red button"},
      steps("pre_blink_off_steps", 1, params.PRE_BLINK_OFF_STEPS, "before the first blink"),
      steps("blink_on_steps", most, BLINK_ON_STEPS, "length of every blink"),
      steps("blink_off_steps", most, BLINK_OFF_STEPS, "darkness after every blink"),
  };
}

Constant color_constant(const mjcf::Rgba& rgba) {
  return ConstantList{rgba[0], rgba[1], rgba[2], rgba[3]};
}

ConstantTable constants_of(const BlinkCountParams& params) {
  ConstantTable table = {
      {"BLINK_COUNT_RANGE", params.BLINK_COUNT_RANGE.constant()},
      {"PRE_BLINK_OFF_STEPS", params.PRE_BLINK_OFF_STEPS.constant()},
      {"BLINK_ON_STEPS", BLINK_ON_STEPS.constant()},
      {"BLINK_OFF_STEPS", BLINK_OFF_STEPS.constant()},
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
      {"ACTION_L2_COEF", kBlinkSmoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", kBlinkSmoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", kBlinkSmoothness.QVEL_L2_COEF},
      {"SUCCESS_BONUS", SUCCESS_BONUS},
      {"FAILURE_PENALTY", FAILURE_PENALTY},
  };
  table.insert(table.end(), more.begin(), more.end());
  add_constants(kRedButton, table);
  return table;
}

std::vector<TaskOption> options() {
  const auto component = [](const char* name, double value) {
    return TaskOption{name,
                      value,
                      false,
                      0,
                      255,
                      "",
                      "colour of the blinking lamp; 0 to 1, or 0 to 255 if one is above 1"};
  };
  return {component("blink_red", 0), component("blink_green", 0), component("blink_blue", 1)};
}

}  // namespace

void describe_blink_count(const BlinkCountParams& params, TaskInfo& info) {
  info.candidates = params.BLINK_COUNT_RANGE.high - params.BLINK_COUNT_RANGE.low + 1;
  info.termination = Termination::kSuccessOrFailed;
  info.success_reward = SUCCESS_BONUS;
  info.oracle_dim = 1;
  info.draws = draws_of(params);
  info.hidden_draw = "target_blinks";
  info.options = options();
  info.constants = constants_of(params);
  info.phases = {{"cue", "elapsed < C: the lamp blinks; presses do not count"},
                 {"action", "elapsed >= C: the phase lamp is green"}};
}

}  // namespace engram::tasks
