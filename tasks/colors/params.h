// What BunchOfColors, SeqOfColors and ChainOfColors are made of: constants, variants and how they
// describe themselves.
#pragma once

#include <string_view>

#include "core/task.h"
#include "tasks/colors/rules.h"
#include "tasks/parts/phase_clock.h"
#include "tasks/parts/press_button.h"

namespace engram::tasks {

struct ColorRecallParams {
  std::string_view id;
  ColorRule rule;
  int SEQUENCE_LENGTH;
  StepRange cue;  // Bunch: of the whole cue; Seq and Chain: of every item
  StepRange EMPTY_PHASE_STEPS;
  PressButtonParams button = {};
};

inline constexpr int COLORS = 9;
inline constexpr double CUBE_HALFSIZE = 0.02;                  // m
inline constexpr double MAX_ALLOWED_CUBE_DISPLACEMENT = 0.06;  // m
inline constexpr double BUTTON_X_SHIFT_TOWARD_ROBOT = -0.04;   // m
inline constexpr double kHiddenHeight = 1000;                  // reported while a cube is hidden
inline constexpr SmoothnessParams kColorSmoothness;            // no weight on anything

// What an episode samples, in the order of TaskInfo::draws, and the options.
enum ColorDraw { kSequence, kPositions, kCueSteps, kEmptySteps };
enum ColorOption { kTouchRadius, kStrictOrder };  // the latter for Seq only

// The variant of that id.
const ColorRecallParams& color_recall_params(std::string_view id);

// Fills in what TaskInfo says of the variant, apart from what the registry knows, reward terms and
// state fields.
void describe_color_recall(const ColorRecallParams& params, TaskInfo& info);

}  // namespace engram::tasks
