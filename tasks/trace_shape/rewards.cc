#include "tasks/trace_shape/rewards.h"

#include <algorithm>

#include "core/math/real_functions.h"

namespace engram::tasks {
namespace {

constexpr double kGraspDistance = 0.05;  // m: a TCP this near counts as a grasp
constexpr double kFailedSubmitReward = -2;

double nearness(double slope, double distance) { return 1 - real::tanh(slope * distance); }

}  // namespace

double TraceReward::compute() {
  reaching = nearness(5, tcp_to_cube);
  grasping = tcp_to_cube < kGraspDistance ? 1 : 0;
  nearest = all_visited ? 0 : grasping * nearness(5, nearest_unvisited);
  closure = all_visited ? nearness(5, start_distance) : 0;
  smooth = tasks::smoothness(action_cost, smoothness);
  if (success) return kTraceShapeSuccessReward;
  const double reward =
      acting ? reaching + 2 * grasping + 3 * visit_fraction + 2 * nearest + 2 * closure
             : 0.5 * reaching;
  return reward - smooth.penalty;
}

double TraceSeqReward::compute() {
  trace.compute();
  button_reach = button_awaits ? nearness(8, button_distance) : 0;
  button_press = button_awaits ? std::clamp(press_fraction, 0.0, 1.0) : 0;
  if (trace.success) return kTraceShapeSeqSuccessReward;
  if (failed_submit) return kFailedSubmitReward;
  const double reward = trace.acting
                            ? trace.reaching + 1.8 * trace.grasping + 2.5 * trace.visit_fraction +
                                  3 * progress + 2 * trace.closure
                            : 0.5 * trace.reaching;
  return reward + (1.5 * button_reach + 2.5 * button_press - trace.smooth.penalty);
}

}  // namespace engram::tasks
