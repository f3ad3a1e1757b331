// Dense rewards of TraceShape and TraceShapeSeq.
#pragma once

#include "tasks/common/action_cost.h"

namespace engram::tasks {

inline constexpr double kTraceShapeSuccessReward = 30;
inline constexpr double kTraceShapeSeqSuccessReward = 40;

// Dense rewards (tasks/common/reward_dict.h).
struct TraceReward {
  double tcp_to_cube = 0;  // m
  bool acting = false;
  double visit_fraction = 0;  // of the shape's checkpoints
  bool all_visited = false;
  double start_distance = 0;     // m, from the cube to the first checkpoint
  double nearest_unvisited = 0;  // m; counts unless all have been visited
  ActionCost action_cost = {};
  bool success = false;
  SmoothnessParams smoothness = {};
  // Terms.
  double reaching = 0;
  double grasping = 0;
  double nearest = 0;
  double closure = 0;
  SmoothnessTerms smooth = {};

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", reaching);
    row.term("is_grasping", "", grasping);
    row.term("visit_fraction", "", visit_fraction);
    row.term("nearest_cp_reward", "", nearest);
    row.term("closure_reward", "", closure);
    row.term("smooth_penalty", "", smooth.penalty);
    row.term("tcp_to_cube_dist", "m", tcp_to_cube);
    row.term("start_checkpoint_dist", "m", start_distance);
  }
};

struct TraceSeqReward {
  TraceReward trace = {};      // of the active shape; nearest_unvisited does not count
  double progress = 0;         // fraction of shapes that are closed
  bool button_awaits = false;  // all shapes are closed and the button was not pressed
  double button_distance = 0;  // m, from the TCP to just above the button
  double press_fraction = 0;   // of the button's travel
  bool failed_submit = false;
  // Terms.
  double button_reach = 0;
  double button_press = 0;

  double compute();
  template <class Visitor>
  void list_terms(Visitor& row) const {
    row.term("reaching_reward", "", trace.reaching);
    row.term("is_grasping", "", trace.grasping);
    row.term("active_visit_fraction", "", trace.visit_fraction);
    row.term("sequence_progress", "", progress);
    row.term("closure_reward", "", trace.closure);
    row.term("button_reach_reward", "", button_reach);
    row.term("button_press_reward", "", button_press);
    row.term("smooth_penalty", "", trace.smooth.penalty);
    row.term("start_checkpoint_dist", "m", trace.start_distance);
  }
};

}  // namespace engram::tasks
