// What tracing is worth in TraceShape and TraceShapeSeq (procedural 1.8, 2.7).
#pragma once

#include "tasks/parts/smoothness.h"

namespace engram::tasks {

inline constexpr SmoothnessParams kTraceSmoothness = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};
inline constexpr double kTraceShapeSuccessReward = 30;
inline constexpr double kTraceShapeSeqSuccessReward = 40;

struct TraceRewardInputs {
  double tcp_to_cube = 0;  // m
  bool acting = false;
  double visit_fraction = 0;  // of the shape's checkpoints
  bool all_visited = false;
  double start_distance = 0;     // m, from the cube to the first checkpoint
  double nearest_unvisited = 0;  // m; counts unless all have been visited
  double smooth_penalty = 0;
  bool success = false;
};

struct TraceRewardTerms {
  double reaching = 0;
  double grasping = 0;
  double nearest = 0;
  double closure = 0;
  double reward = 0;
};

TraceRewardTerms trace_reward(const TraceRewardInputs& inputs);

// On top of that, in a sequence.
struct TraceSeqRewardInputs {
  TraceRewardInputs trace;     // of the active shape; nearest_unvisited does not count
  double progress = 0;         // fraction of shapes that are closed
  bool button_awaits = false;  // all shapes are closed and the button was not pressed
  double button_distance = 0;  // m, from the TCP to just above the button
  double press_fraction = 0;   // of the button's travel
  bool failed_submit = false;
};

struct TraceSeqRewardTerms {
  double reaching = 0;
  double grasping = 0;
  double closure = 0;
  double button_reach = 0;
  double button_press = 0;
  double reward = 0;
};

TraceSeqRewardTerms trace_seq_reward(const TraceSeqRewardInputs& inputs);

}  // namespace engram::tasks
