// Constants and variants of TraceShape and TraceShapeSeq.
#pragma once

#include <array>

#include "tasks/common/action_cost.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/press_button.h"
#include "tasks/common/random_variables.h"
#include "tasks/family.h"
#include "tasks/trace_shape/contour.h"

namespace engram::tasks {

struct TraceParams {
  TaskSpec task;
  NameList AVAILABLE_SHAPES;
  bool sequence = false;  // of several shapes
  int MIN_SEQUENCE_LENGTH = 1;
  int MAX_SEQUENCE_LENGTH = 1;
  ContourParams contours = {};
  StepRange PRE_DEMO_STEPS{3, 8};
  SampledRange<double> SHAPE_RADIUS_RANGE{0.078, 0.13};  // m
  SmoothnessParams smoothness = {
      .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

  void declare(ConstantBinder& constants);
  void declare_sequence(ConstantBinder& constants);
  void check(int horizon) const;

  // Distances from a shape's centre to its farthest corner, and to its nearest point, m.
  double farthest_corner() const;
  double nearest_point() const;
};

inline constexpr std::array<TraceParams, 3> kTraceVariants = {{
    {{"TraceShapeEasy-VLA-v0", 250, Split::kMedium}, NameList(1)},
    {{"TraceShapeHard-VLA-v0", 350, Split::kMedium}, NameList(3)},
    {{"TraceShapeMedium-VLA-v0", 300, Split::kMedium}, NameList(2)},
}};
inline constexpr std::array<TraceParams, 3> kTraceSeqVariants = {{
    {{"TraceShapeSeqEasy-VLA-v0", 1500, Split::kLong, 0.90}, NameList(1), true, 2, 5},
    {{"TraceShapeSeqHard-VLA-v0", 1500, Split::kLong, 0.90}, NameList(3), true, 2, 5},
    {{"TraceShapeSeqMedium-VLA-v0", 1500, Split::kLong, 0.90}, NameList(2), true, 2, 5},
}};

inline constexpr double CUBE_HALFSIZE = 0.02;                          // m
inline constexpr Interval<double> SHAPE_CENTER_X_RANGE{-0.15, -0.05};  // m
inline constexpr Interval<double> SHAPE_CENTER_Y_RANGE{-0.10, 0.10};   // m
inline constexpr double GREEN_CUBE_OFFSET_X = -0.16;                   // m
inline constexpr double LAMP_OFFSET_X = 0.25;                          // m
inline constexpr double kTraceHiddenOffset = 1000;         // m: reported height of what is hidden
inline constexpr double BUTTON_OFFSET_FROM_LAMP_X = 0.02;  // m
inline constexpr double BUTTON_OFFSET_FROM_LAMP_Y = 0.16;  // m
inline constexpr PressButtonParams kSubmitButton;          // of a sequence

}  // namespace engram::tasks
