#include "tasks/colors/params.h"

#include <array>

#include "tasks/parts/colors.h"
#include "tasks/parts/touch_target.h"

namespace engram::tasks {
namespace {

// Ways to choose a set, or a sequence, of that many colours.
int count_answers(const ColorRecallParams& params) {
  int ways = 1;
  for (int i = 0; i < params.SEQUENCE_LENGTH; ++i) {
    ways *= COLORS - i;
    if (params.rule != ColorRule::kChain) ways /= i + 1;
  }
  return ways;
}

std::vector<Draw> draws_of(const ColorRecallParams& params) {
  const auto steps = [](const char* name, StepRange range, const char* what) {
    return Draw{name,
                1,
                true,
                static_cast<double>(range.low),
                static_cast<double>(range.high),
                "control steps",
                what};
  };
  const bool bunch = params.rule == ColorRule::kBunch;
  return {
      {"sequence", params.SEQUENCE_LENGTH, true, 0, COLORS - 1.0, "",
       "colours of the cue, in its order", true},
      {"positions", 2 * COLORS, false, -0.5, 0.5, "m", "x, y of every cube in the action phase"},
      bunch ? steps("cue_steps", params.cue, "length of the cue phase")
            : steps("cue_step_duration", params.cue, "length of every item of the cue"),
      steps("empty_steps", params.EMPTY_PHASE_STEPS, "length of the empty phase"),
  };
}

ConstantTable constants_of(const ColorRecallParams& params) {
  const bool bunch = params.rule == ColorRule::kBunch;
  ConstantTable table = {
      {"COLORS", COLORS},
      {"COLOR_MAPPING", color_mapping_constant()},
      {"SEQUENCE_LENGTH", params.SEQUENCE_LENGTH},
      {"GOAL_THRESH", GOAL_THRESH},
      {"CUBE_HALFSIZE", CUBE_HALFSIZE},
      {bunch ? "CUE_PHASE_STEPS" : "CUE_STEP_DURATION", params.cue.constant()},
      {"EMPTY_PHASE_STEPS", params.EMPTY_PHASE_STEPS.constant()},
      {"ACTION_L2_COEF", kColorSmoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", kColorSmoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", kColorSmoothness.QVEL_L2_COEF},
      {"CUBE_DISPLACEMENT_PENALTY_COEF", CUBE_DISPLACEMENT_PENALTY_COEF},
      {"MAX_ALLOWED_CUBE_DISPLACEMENT", MAX_ALLOWED_CUBE_DISPLACEMENT},
      {"BUTTON_HIDDEN_Z", kHiddenHeight},
      {"BUTTON_X_SHIFT_TOWARD_ROBOT", BUTTON_X_SHIFT_TOWARD_ROBOT},
  };
  add_constants(params.button, table);
  return table;
}

}  // namespace

void describe_color_recall(const ColorRecallParams& params, TaskInfo& info) {
  info.candidates = count_answers(params);
  info.termination = Termination::kNever;
  info.success_reward = kColorSuccessReward;
  info.oracle_dim = params.SEQUENCE_LENGTH;
  info.draws = draws_of(params);
  info.hidden_draw = "sequence";
  info.options = {{"touch_radius", GOAL_THRESH, false, 0.001, 0.2, "m",
                   "how near its touch point a cube is touched", CUBE_HALFSIZE}};
  if (params.rule == ColorRule::kSeq) {
    info.options.push_back(
        {"strict_order", 0, true, 0, 1, "", "1: the order of the cue counts", 1});
  }
  info.constants = constants_of(params);
  info.phases = {{"cue", "elapsed < C"},
                 {"empty", "C <= elapsed < C + E"},
                 {"action", "elapsed >= C + E; cubes are put back up to C + E + 4"}};
}

}  // namespace engram::tasks
