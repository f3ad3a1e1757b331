#include "tasks/colors/params.h"

#include <string>

#include "core/base/error.h"
#include "tasks/common/colors.h"
#include "tasks/common/phase_budget.h"

namespace engram::tasks {
namespace {

// Control steps that the last part of an episode takes at least.
constexpr int kTimeToTouch = 8;
constexpr int kTimeToPress = 15;

// Number of ways to choose a set, or a sequence, of that many colours.
int count_answers(const ColorRecallParams& params) {
  int ways = 1;
  for (int i = 0; i < params.SEQUENCE_LENGTH; ++i) {
    ways *= params.COLORS - i;
    if (params.rule != ColorRule::kChain) ways /= i + 1;
  }
  return ways;
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

void ColorRecallParams::declare(ConstantBinder& constants) {
  constexpr auto kMax = static_cast<double>(COLOR_MAPPING.size());
  constants.integer("SEQUENCE_LENGTH", SEQUENCE_LENGTH, {1, kMax}, "", "cubes that the cue shows");
  constants.integer("COLORS", COLORS, {2, kMax}, "",
                    "cubes, in the first colours of the colour table");
  constants.fixed({{"COLOR_MAPPING", color_mapping_constant()}});
  declare_phases(constants);
  if (has_button()) {
    constants.real("GOAL_THRESH", GOAL_THRESH, {0.01, 0.1}, "m",
                   "how near its touch point, 5 mm above a cube, the tool has to come");
  } else {
    constants.fixed({{"GOAL_THRESH", GOAL_THRESH}});
  }
  constants.real("CUBE_HALFSIZE", CUBE_HALFSIZE, {0.01, 0.035}, "m", "half the side of a cube");
  if (!has_button()) return;
  smoothness.declare(constants);
  constants.fixed({{"CUBE_DISPLACEMENT_PENALTY_COEF", CUBE_DISPLACEMENT_PENALTY_COEF},
                   {"MAX_ALLOWED_CUBE_DISPLACEMENT", MAX_ALLOWED_CUBE_DISPLACEMENT},
                   {"BUTTON_HIDDEN_Z", kHiddenHeight},
                   {"BUTTON_X_SHIFT_TOWARD_ROBOT", BUTTON_X_SHIFT_TOWARD_ROBOT}});
  constants.fixed([&] {
    button.declare(constants);
    button.declare_lift(constants);
  });
}

void ColorRecallParams::declare_phases(ConstantBinder& constants) {
  const bool bunch = rule == ColorRule::kBunch;
  // The original's RL tasks have one length of each phase, by other names.
  const bool published = has_button();
  if (bunch) {
    constants
        .steps("CUE_PHASE_STEPS", cue, kPhaseSteps, "how long the cue is shown",
               {"cue_steps", "length of the cue phase"})
        .published = published;
  } else {
    constants
        .steps("CUE_STEP_DURATION", cue, kPhaseSteps, "how long each cube of the cue is shown",
               {"cue_step_duration", "length of every item of the cue"})
        .published = published;
  }
  constants
      .steps("EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS, kPhaseSteps, "how long no cube shows then",
             {"empty_steps", "length of the empty phase"})
      .published = published;
  if (published) return;
  constants.fixed({{bunch ? "TIME_OFFSET" : "STEP_DURATION", cue.high},
                   {"EMPTY_DURATION", EMPTY_PHASE_STEPS.high}});
}

void ColorRecallParams::check(int horizon) const {
  check_answers(*this);
  const bool bunch = rule == ColorRule::kBunch;
  check_horizon(
      horizon,
      {{bunch ? "CUE_PHASE_STEPS" : "SEQUENCE_LENGTH x CUE_STEP_DURATION", cue_items() * cue.high},
       {"EMPTY_PHASE_STEPS", EMPTY_PHASE_STEPS.high}},
      kTimeToTouch * SEQUENCE_LENGTH + (has_button() ? kTimeToPress : 0));
}

ColorVariables::ColorVariables(RandomVariables list, const ColorRecallParams& params)
    : sequence(list.add({"sequence", params.SEQUENCE_LENGTH, true, 0, params.COLORS - 1.0, "",
                         "colours of the cue, in its order", true})),
      positions(list.add({"positions", 2 * params.COLORS, false, -0.5, 0.5, "m",
                          "x, y of every cube in the action phase"})),
      cue_steps(list.of(params.cue)),
      empty_steps(list.of(params.EMPTY_PHASE_STEPS)) {}

ColorOptions::ColorOptions(TaskOptions list, const ColorRecallParams& params) {
  TaskOptionSpec radius{"touch_radius",
                        params.CUBE_HALFSIZE,
                        false,
                        0.001,
                        0.2,
                        "m",
                        "how near its touch point a cube is touched"};
  if (params.has_button()) {
    radius.value = params.GOAL_THRESH;
    radius.original = params.CUBE_HALFSIZE;
  }
  touch_radius = list.add(radius);
  if (!params.has_button()) return;
  if (params.rule == ColorRule::kSeq) {
    strict_order = list.on_off("strict_order", "1: the order of the cue counts", /*original=*/true);
  }
  if (params.rule == ColorRule::kChain) {
    repeated_touches = list.on_off("repeated_touches", "1: a cube may be touched again",
                                   /*original=*/true);
  }
}

void describe_color_recall(const ColorRecallParams& params, TaskInfo& info) {
  info.candidates = count_answers(params);
  info.answer =
      "the touches up to the first one that is wrong, or to the last one that is needed; a digit "
      "per touch, in their order: 1 + the colour's number";
  const bool button = params.has_button();
  info.success_reward = button ? kColorSuccessReward : kColorTouchSuccessReward;
  info.oracle_dim = params.SEQUENCE_LENGTH;
  info.hidden_variable = "sequence";
  info.phases = {{"cue", "elapsed < C"},
                 {"empty", "C <= elapsed < C + E"},
                 {"action", button ? "elapsed >= C + E; cubes are put back up to C + E + 4"
                                   : "elapsed >= C + E"}};
}

}  // namespace engram::tasks
