#include "tasks/trace_shape/rewards.h"

#include <algorithm>

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

constexpr double kGraspDistance = 0.05;  // m: a TCP this near counts as a grasp
constexpr double kFailedSubmitReward = -2;

double nearness(double slope, double distance) { return 1 - real::tanh(slope * distance); }

}  // namespace

TraceRewardTerms trace_reward(const TraceRewardInputs& in, const SmoothnessParams& weights) {
  TraceRewardTerms terms;
  terms.reaching = nearness(5, in.tcp_to_cube);
  terms.grasping = in.tcp_to_cube < kGraspDistance ? 1 : 0;
  terms.nearest = in.all_visited ? 0 : terms.grasping * nearness(5, in.nearest_unvisited);
  terms.closure = in.all_visited ? nearness(5, in.start_distance) : 0;
  terms.reward = in.acting ? terms.reaching + 2 * terms.grasping + 3 * in.visit_fraction +
                                 2 * terms.nearest + 2 * terms.closure
                           : 0.5 * terms.reaching;
  terms.smooth = smoothness(in.action_cost, weights);
  terms.reward -= terms.smooth.penalty;
  if (in.success) terms.reward = kTraceShapeSuccessReward;
  return terms;
}

TraceSeqRewardTerms trace_seq_reward(const TraceSeqRewardInputs& in,
                                     const SmoothnessParams& weights) {
  const TraceRewardInputs& trace = in.trace;
  TraceSeqRewardTerms terms;
  terms.reaching = nearness(5, trace.tcp_to_cube);
  terms.grasping = trace.tcp_to_cube < kGraspDistance ? 1 : 0;
  terms.closure = trace.all_visited ? nearness(5, trace.start_distance) : 0;
  terms.button_reach = in.button_awaits ? nearness(8, in.button_distance) : 0;
  terms.button_press = in.button_awaits ? std::clamp(in.press_fraction, 0.0, 1.0) : 0;
  terms.smooth = smoothness(trace.action_cost, weights);
  terms.reward = trace.acting ? terms.reaching + 1.8 * terms.grasping + 2.5 * trace.visit_fraction +
                                    3 * in.progress + 2 * terms.closure
                              : 0.5 * terms.reaching;
  terms.reward += 1.5 * terms.button_reach + 2.5 * terms.button_press - terms.smooth.penalty;
  if (in.failed_submit) terms.reward = kFailedSubmitReward;
  if (trace.success) terms.reward = kTraceShapeSeqSuccessReward;
  return terms;
}

}  // namespace engram::tasks
