// Constants, variants and descriptions of BunchOfColors, SeqOfColors and ChainOfColors.
#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "core/task/task.h"
#include "tasks/colors/reward.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/press_button.h"
#include "tasks/common/random_variables.h"
#include "tasks/common/task_options.h"
#include "tasks/family.h"

namespace engram::tasks {

struct ColorRecallParams {
  TaskSpec task;
  ColorRule rule;
  int SEQUENCE_LENGTH;
  StepRange cue;  // Bunch: CUE_PHASE_STEPS, of the whole cue; else CUE_STEP_DURATION, of every item
  StepRange EMPTY_PHASE_STEPS;
  int COLORS = 9;               // cubes, in the first colours of the colour table
  double GOAL_THRESH = 0.05;    // m
  double CUBE_HALFSIZE = 0.02;  // m
  // Action costs of the VLA tasks.
  SmoothnessParams smoothness = {};
  PressButtonParams button = {};

  // True for the VLA tasks, which end with a press. Where there is no button, cubes stand closer
  // together, and are touched within CUBE_HALFSIZE instead of GOAL_THRESH.
  bool has_button() const { return !task.is_rl(); }
  // Number of times that the cue lasts as long as is drawn.
  int cue_items() const { return rule == ColorRule::kBunch ? 1 : SEQUENCE_LENGTH; }
  // The step count by which all cubes stand on the table, whatever an episode draws.
  int latest_start() const { return cue_items() * cue.high + EMPTY_PHASE_STEPS.high; }

  void declare(ConstantBinder& constants);
  void check(int horizon) const;

 private:
  void declare_phases(ConstantBinder& constants);
};

inline constexpr StepRange kShortCue{1, 5};
inline constexpr StepRange kLongCue{10, 100};
inline constexpr StepRange kShortEmpty{1, 5};
inline constexpr StepRange kLongEmpty{50, 400};
inline constexpr StepRange kRlCue{5, 5};
inline constexpr StepRange kRlEmpty{5, 5};

inline constexpr std::string_view kRlSetInstruction =
    "Observe which colored cubes appear during the cue, wait, then touch all of them in any order.";
inline constexpr std::string_view kRlOrderInstruction =
    "Observe which colored cubes appear during the cue, wait, then touch all of them in the same "
    "order as the cubes were shown.";

// An RL task.
constexpr ColorRecallParams rl_variant(std::string_view id, ColorRule rule, int length) {
  const bool ordered = rule == ColorRule::kChain;
  return {{.id = id,
           .horizon = 120,
           .split = Split::kRl,
           .instruction = ordered ? kRlOrderInstruction : kRlSetInstruction},
          rule,
          length,
          kRlCue,
          kRlEmpty};
}

inline constexpr std::array<ColorRecallParams, 9> kSeqVariants = {{
    {{"SeqOfColors3-Long-VLA-v0", 800, Split::kLong}, ColorRule::kSeq, 3, kLongCue, kLongEmpty},
    {{"SeqOfColors3-VLA-v0", 400, Split::kMedium}, ColorRule::kSeq, 3, kShortCue, kShortEmpty},
    {{"SeqOfColors5-Long-VLA-v0", 1000, Split::kLong}, ColorRule::kSeq, 5, kLongCue, kLongEmpty},
    {{"SeqOfColors5-VLA-v0", 400, Split::kMedium}, ColorRule::kSeq, 5, kShortCue, kShortEmpty},
    {{"SeqOfColors7-Long-VLA-v0", 1200, Split::kLong}, ColorRule::kSeq, 7, kLongCue, kLongEmpty},
    {{"SeqOfColors7-VLA-v0", 400, Split::kMedium}, ColorRule::kSeq, 7, kShortCue, kShortEmpty},
    rl_variant("SeqOfColors3-v0", ColorRule::kSeq, 3),
    rl_variant("SeqOfColors5-v0", ColorRule::kSeq, 5),
    rl_variant("SeqOfColors7-v0", ColorRule::kSeq, 7),
}};
inline constexpr std::array<ColorRecallParams, 9> kChainVariants = {{
    {{"ChainOfColors3-Long-VLA-v0", 800, Split::kLong}, ColorRule::kChain, 3, kLongCue, kLongEmpty},
    {{"ChainOfColors3-VLA-v0", 400, Split::kMedium}, ColorRule::kChain, 3, kShortCue, kShortEmpty},
    {{"ChainOfColors5-Long-VLA-v0", 1000, Split::kLong},
     ColorRule::kChain,
     5,
     kLongCue,
     kLongEmpty},
    {{"ChainOfColors5-VLA-v0", 400, Split::kMedium}, ColorRule::kChain, 5, kShortCue, kShortEmpty},
    {{"ChainOfColors7-Long-VLA-v0", 1200, Split::kLong},
     ColorRule::kChain,
     7,
     kLongCue,
     kLongEmpty},
    {{"ChainOfColors7-VLA-v0", 400, Split::kMedium}, ColorRule::kChain, 7, kShortCue, kShortEmpty},
    rl_variant("ChainOfColors3-v0", ColorRule::kChain, 3),
    rl_variant("ChainOfColors5-v0", ColorRule::kChain, 5),
    rl_variant("ChainOfColors7-v0", ColorRule::kChain, 7),
}};
inline constexpr std::array<ColorRecallParams, 9> kBunchVariants = {{
    {{"BunchOfColors3-Long-VLA-v0", 700, Split::kLong}, ColorRule::kBunch, 3, kLongCue, kLongEmpty},
    {{"BunchOfColors3-VLA-v0", 400, Split::kMedium}, ColorRule::kBunch, 3, kShortCue, kShortEmpty},
    {{"BunchOfColors5-Long-VLA-v0", 700, Split::kLong}, ColorRule::kBunch, 5, kLongCue, kLongEmpty},
    {{"BunchOfColors5-VLA-v0", 400, Split::kMedium}, ColorRule::kBunch, 5, kShortCue, kShortEmpty},
    {{"BunchOfColors7-Long-VLA-v0", 700, Split::kLong}, ColorRule::kBunch, 7, kLongCue, kLongEmpty},
    {{"BunchOfColors7-VLA-v0", 400, Split::kMedium}, ColorRule::kBunch, 7, kShortCue, kShortEmpty},
    rl_variant("BunchOfColors3-v0", ColorRule::kBunch, 3),
    rl_variant("BunchOfColors5-v0", ColorRule::kBunch, 5),
    rl_variant("BunchOfColors7-v0", ColorRule::kBunch, 7),
}};

inline constexpr double MAX_ALLOWED_CUBE_DISPLACEMENT = 0.06;  // m
inline constexpr double BUTTON_X_SHIFT_TOWARD_ROBOT = -0.04;   // m
inline constexpr double kHiddenHeight = 1000;                  // reported while a cube is hidden

// Random variables of an episode.
struct ColorVariables {
  ColorVariables(RandomVariables list, const ColorRecallParams& params);

  VariableHandle sequence;
  VariableHandle positions;
  IntegerVariable cue_steps;
  IntegerVariable empty_steps;
};

struct ColorOptions {
  ColorOptions(TaskOptions list, const ColorRecallParams& params);

  TaskOption touch_radius;
  std::optional<TaskOption> strict_order;      // Seq
  std::optional<TaskOption> repeated_touches;  // Chain
};

// Fills in TaskInfo, apart from what the registry knows, reward terms and state fields.
void describe_color_recall(const ColorRecallParams& params, TaskInfo& info);

}  // namespace engram::tasks
