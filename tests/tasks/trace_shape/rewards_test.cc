// Rewards of TraceShape and TraceShapeSeq in worked examples.
#include "tasks/trace_shape/rewards.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::tasks {
namespace {

constexpr SmoothnessParams kWeights = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.03, .QVEL_L2_COEF = 0.01};

// The first action of an episode, a change from zeros.
constexpr ActionCost kActionCost{
    .action_norm = 1.593738, .action_delta_norm = 1.593738, .arm_speed = 0.4};

TEST_CASE("The smoothness penalty of these families", "[trace]") {
  CHECK(smoothness(kActionCost, kWeights).penalty == Approx(0.046606).margin(5e-7));
}

TEST_CASE("TraceShape rewards as in the worked example", "[trace]") {
  TraceReward in{.smoothness = kWeights};
  in.acting = true;
  in.tcp_to_cube = 0.03;
  in.visit_fraction = 5.0 / 12;
  in.nearest_unvisited = 0.04;
  in.start_distance = 0.1;
  in.action_cost = kActionCost;
  const double reward = in.compute();
  CHECK(in.reaching == Approx(0.851115).margin(1e-6));
  CHECK(in.grasping == 1);
  CHECK(reward == Approx(5.659758).margin(2e-6));
  CHECK(reward / kTraceShapeSuccessReward == Approx(0.188659).margin(1e-6));

  in.acting = false;
  CHECK(in.compute() == Approx(0.5 * 0.851115 - 0.046606).margin(2e-6));
  in.success = true;
  CHECK(in.compute() == 30);
}

TEST_CASE("A visited contour pulls to its start, not to checkpoints", "[trace]") {
  TraceReward in{.smoothness = kWeights};
  in.acting = true;
  in.tcp_to_cube = 0.06;  // not a grasp
  in.visit_fraction = 1;
  in.all_visited = true;
  in.start_distance = 0.2;
  const double reward = in.compute();
  CHECK(in.grasping == 0);
  CHECK(in.nearest == 0);
  CHECK(in.closure == Approx(1 - std::tanh(1.0)));
  CHECK(reward == Approx(1 - std::tanh(0.3) + 3 + 2 * (1 - std::tanh(1.0))));
}

TEST_CASE("TraceShapeSeq rewards as in the worked examples", "[trace]") {
  TraceSeqReward in{.trace = {.smoothness = kWeights}};
  in.trace.acting = true;
  in.trace.tcp_to_cube = 0.03;
  in.trace.visit_fraction = 4.0 / 12;
  in.trace.action_cost = kActionCost;
  in.progress = 1.0 / 3;
  CHECK(in.compute() == Approx(4.437842).margin(2e-6));

  in.trace.tcp_to_cube = 0.3;
  in.trace.visit_fraction = 1;
  in.trace.all_visited = true;
  in.trace.start_distance = 0.2;
  in.progress = 1;
  in.button_awaits = true;
  in.button_distance = 0.084 - 0.063;
  in.press_fraction = 0.004 / 0.014;
  CHECK(in.compute() == Approx(7.989687).margin(2e-6));

  in.failed_submit = true;
  CHECK(in.compute() == -2);
  in.trace.success = true;  // applied last
  CHECK(in.compute() == 40);
}

}  // namespace
}  // namespace engram::tasks
