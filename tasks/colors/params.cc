#include "tasks/colors/params.h"

#include <string>

#include "core/base/error.h"
#include "tasks/colors/cubes.h"
#include "tasks/common/colors.h"

namespace engram::tasks {
namespace {

// Control steps that the last part of an episode takes at least.
constexpr int kTimeToTouch = 8;
constexpr int kTimeToPress = 15;

// Ways to choose a set, or a sequence, of that many colours.
int count_answers(const ColorRecallParams& params) {
  int ways = 1;
  for (int i = 0; i < params.SEQUENCE_LENGTH; ++i) {
    ways *= params.COLORS - i;
    if (params.rule != ColorRule::kChain) ways /= i + 1;
  }
  return ways;
}

const char* cue_name(const ColorRecallParams& params) {
  return params.rule == ColorRule::kBunch ? "CUE_PHASE_STEPS" : "CUE_STEP_DURATION";
}

std::vector<RandomVariable> draws_of(const ColorRecallParams& params) {
  const bool bunch = params.rule == ColorRule::kBunch;
  return {
      {"sequence", params.SEQUENCE_LENGTH, true, 0, params.COLORS - 1.0, "",
       "colours of the cue, in its order", true},
      {"positions", 2 * params.COLORS, false, -0.5, 0.5, "m",
       "x, y of every cube in the action phase"},
      bunch ? params.cue.draw("cue_steps", "length of the cue phase", cue_name(params))
            : params.cue.draw("cue_step_duration", "length of every item of the cue",
                              cue_name(params)),
      params.EMPTY_PHASE_STEPS.draw("empty_steps", "length of the empty phase",
                                    "EMPTY_PHASE_STEPS"),
  };
}

ConstantTable constants_of(const ColorRecallParams& params) {
  ConstantTable table = {
      {"COLORS", params.COLORS},
      {"COLOR_MAPPING", color_mapping_constant()},
      {"SEQUENCE_LENGTH", params.SEQUENCE_LENGTH},
      {"GOAL_THRESH", params.GOAL_THRESH},
      {"CUBE_HALFSIZE", params.CUBE_HALFSIZE},
      {cue_name(params), params.cue.constant()},
      {"EMPTY_PHASE_STEPS", params.EMPTY_PHASE_STEPS.constant()},
      {"ACTION_L2_COEF", params.smoothness.ACTION_L2_COEF},
      {"ACTION_DELTA_L2_COEF", params.smoothness.ACTION_DELTA_L2_COEF},
      {"QVEL_L2_COEF", params.smoothness.QVEL_L2_COEF},
      {"CUBE_DISPLACEMENT_PENALTY_COEF", CUBE_DISPLACEMENT_PENALTY_COEF},
      {"MAX_ALLOWED_CUBE_DISPLACEMENT", MAX_ALLOWED_CUBE_DISPLACEMENT},
      {"BUTTON_HIDDEN_Z", kHiddenHeight},
      {"BUTTON_X_SHIFT_TOWARD_ROBOT", BUTTON_X_SHIFT_TOWARD_ROBOT},
  };
  add_constants(params.button, table);
  return table;
}

// Throws Error unless there is something to choose among the colours.
void check_answers(const ColorRecallParams& params) {
  const bool ordered = params.rule == ColorRule::kChain;
  const int most = params.COLORS - (ordered ? 0 : 1);
  if (params.SEQUENCE_LENGTH <= most) return;
  refuse_constant("SEQUENCE_LENGTH", std::to_string(params.SEQUENCE_LENGTH),
                  "at most " + std::to_string(most) + " of " + std::to_string(params.COLORS) +
                      " COLORS allowed" + (ordered ? "" : ", or there is one answer only"));
}

}  // namespace

void ColorRecallParams::constants(Changes& list) {
  constexpr auto kMost = static_cast<double>(COLOR_MAPPING.size());
  const bool bunch = rule == ColorRule::kBunch;
  list.integer("SEQUENCE_LENGTH", SEQUENCE_LENGTH, {1, kMost}, "", "cubes that the cue shows");
  list.integer("COLORS", COLORS, {2, kMost}, "",
               "cubes, in the first so many colours of the colour table");
  list.steps(cue_name(*this), cue, kPhaseSteps,
             bunch ? "how long the cue is shown" : "how long each cube of the cue is shown");
  list.steps("EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS, kPhaseSteps, "how long no cube shows then");
  list.real("GOAL_THRESH", GOAL_THRESH, {0.01, 0.1}, "m",
            "how near its touch point, 5 mm above a cube, the tool has to come");
  list.real("CUBE_HALFSIZE", CUBE_HALFSIZE, {0.01, 0.035}, "m", "half the side of a cube");
  smoothness.constants(list);
}

void ColorRecallParams::check(int horizon) const {
  check_answers(*this);
  const bool bunch = rule == ColorRule::kBunch;
  check_time(
      horizon,
      {{bunch ? "CUE_PHASE_STEPS" : "SEQUENCE_LENGTH x CUE_STEP_DURATION", cue_items() * cue.high},
       {"EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS.high}},
      kTimeToTouch * SEQUENCE_LENGTH + kTimeToPress);
  check_places(*this);
}

void describe_color_recall(const ColorRecallParams& params, TaskInfo& info) {
  info.candidates = count_answers(params);
  info.answer =
      "the touches up to the first one that is wrong, or to the last one that is needed; a digit "
      "per touch, in their order: 1 + the colour's number";
  info.termination = Termination::kNever;
  info.success_reward = kColorSuccessReward;
  info.oracle_dim = params.SEQUENCE_LENGTH;
  info.random_variables = draws_of(params);
  info.hidden_variable = "sequence";
  info.options = {{"touch_radius", params.GOAL_THRESH, false, 0.001, 0.2, "m",
                   "how near its touch point a cube is touched", params.CUBE_HALFSIZE}};
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
