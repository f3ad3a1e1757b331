// Dense rewards of TraceShape and TraceShapeSeq.
#pragma once

#include "tasks/common/action_cost.h"

namespace engram::tasks {

inline constexpr double kTraceShapeSuccessReward = 30;
inline constexpr double kTraceShapeSeqSuccessReward = 40;

struct TraceRewardInputs {
  double tcp_to_cube = 0;  // m
  bool acting = false;
  double visit_fraction = 0;  // of the shape's checkpoints
  bool all_visited = false;
  double start_distance = 0;     // m, from the cube to the first checkpoint
  double nearest_unvisited = 0;  // m; counts unless all have been visited
  ActionCost action_cost;
  bool success = false;
};

struct TraceRewardTerms {
  double reaching = 0;
  double grasping = 0;
  double nearest = 0;
  double closure = 0;
  SmoothnessTerms smooth;
  double reward = 0;
};

template <class Visitor>
void list_terms(Visitor& row, const TraceRewardInputs& in, const TraceRewardTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("is_grasping", "", terms.grasping);
  row.term("visit_fraction", "", in.visit_fraction);
  row.term("nearest_cp_reward", "", terms.nearest);
  row.term("closure_reward", "", terms.closure);
  row.term("smooth_penalty", "", terms.smooth.penalty);
  row.term("tcp_to_cube_dist", "m", in.tcp_to_cube);
  row.term("start_checkpoint_dist", "m", in.start_distance);
}

TraceRewardTerms trace_reward(const TraceRewardInputs& inputs, const SmoothnessParams& weights);

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
  SmoothnessTerms smooth;
  double reward = 0;
};

template <class Visitor>
void list_terms(Visitor& row, const TraceSeqRewardInputs& in, const TraceSeqRewardTerms& terms) {
  row.term("reaching_reward", "", terms.reaching);
  row.term("is_grasping", "", terms.grasping);
  row.term("active_visit_fraction", "", in.trace.visit_fraction);
  row.term("sequence_progress", "", in.progress);
  row.term("closure_reward", "", terms.closure);
  row.term("button_reach_reward", "", terms.button_reach);
  row.term("button_press_reward", "", terms.button_press);
  row.term("smooth_penalty", "", terms.smooth.penalty);
  row.term("start_checkpoint_dist", "m", in.trace.start_distance);
}

TraceSeqRewardTerms trace_seq_reward(const TraceSeqRewardInputs& inputs,
                                     const SmoothnessParams& weights);

}  // namespace engram::tasks
