// Variants and constants of TraceShape and TraceShapeSeq.
#pragma once

#include <array>

#include "tasks/common/changes.h"
#include "tasks/common/smoothness.h"
#include "tasks/family.h"
#include "tasks/trace_shape/contour.h"

namespace engram::tasks {

struct TraceParams {
  TaskRow task;
  NameList AVAILABLE_SHAPES;
  bool sequence = false;  // of several shapes
  int MIN_SEQUENCE_LENGTH = 1;
  int MAX_SEQUENCE_LENGTH = 1;
  ContourParams contours = {};
  std::array<double, 2> SHAPE_RADIUS_RANGE{0.078, 0.13};  // m
  SmoothnessParams smoothness = {
      .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

  void constants(Changes& list);
  void check(int horizon) const;

  // From a shape's centre to its farthest corner, and to its nearest point, m.
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

inline constexpr StepRange PRE_DEMO_STEPS{3, 8};
inline constexpr double GREEN_CUBE_OFFSET_X = -0.16;  // m
inline constexpr double LAMP_OFFSET_X = 0.25;         // m

}  // namespace engram::tasks
