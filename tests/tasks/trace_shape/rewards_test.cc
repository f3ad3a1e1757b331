// The examples of procedural 0.5, 1.8, 2.7, 3.4 and 3.7.
#include "tasks/trace_shape/rewards.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tasks/timed_transfer/rules.h"

namespace engram::tasks {
namespace {

// Example of 0.5: the first action of an episode, a change from zeros.
double example_penalty() {
  const Haste haste{1.593738, 1.593738, 0.4};
  return smoothness(haste, kTraceSmoothness).penalty;
}

TEST_CASE("The smoothness penalty of these families", "[trace]") {
  CHECK(example_penalty() == Approx(0.046606).margin(5e-7));
}

TEST_CASE("TraceShape rewards as in the worked example", "[trace]") {
  TraceRewardInputs in;
  in.acting = true;
  in.tcp_to_cube = 0.03;
  in.visit_fraction = 5.0 / 12;
  in.nearest_unvisited = 0.04;
  in.start_distance = 0.1;
  in.smooth_penalty = example_penalty();
  const TraceRewardTerms terms = trace_reward(in);
  CHECK(terms.reaching == Approx(0.851115).margin(1e-6));
  CHECK(terms.grasping == 1);
  CHECK(terms.reward == Approx(5.659758).margin(2e-6));
  CHECK(terms.reward / kTraceShapeSuccessReward == Approx(0.188659).margin(1e-6));

  in.acting = false;
  CHECK(trace_reward(in).reward == Approx(0.5 * 0.851115 - 0.046606).margin(2e-6));
  in.success = true;
  CHECK(trace_reward(in).reward == 30);
}

TEST_CASE("A visited contour pulls to its start, not to checkpoints", "[trace]") {
  TraceRewardInputs in;
  in.acting = true;
  in.tcp_to_cube = 0.06;  // not a grasp
  in.visit_fraction = 1;
  in.all_visited = true;
  in.start_distance = 0.2;
  const TraceRewardTerms terms = trace_reward(in);
  CHECK(terms.grasping == 0);
  CHECK(terms.nearest == 0);
  CHECK(terms.closure == Approx(1 - std::tanh(1.0)));
  CHECK(terms.reward == Approx(1 - std::tanh(0.3) + 3 + 2 * (1 - std::tanh(1.0))));
}

TEST_CASE("TraceShapeSeq rewards as in the worked examples", "[trace]") {
  TraceSeqRewardInputs in;
  in.trace.acting = true;
  in.trace.tcp_to_cube = 0.03;
  in.trace.visit_fraction = 4.0 / 12;
  in.trace.smooth_penalty = example_penalty();
  in.progress = 1.0 / 3;
  CHECK(trace_seq_reward(in).reward == Approx(4.437842).margin(2e-6));

  in.trace.tcp_to_cube = 0.3;
  in.trace.visit_fraction = 1;
  in.trace.all_visited = true;
  in.trace.start_distance = 0.2;
  in.progress = 1;
  in.button_awaits = true;
  in.button_distance = 0.084 - 0.063;
  in.press_fraction = 0.004 / 0.014;
  const TraceSeqRewardTerms terms = trace_seq_reward(in);
  CHECK(terms.reward == Approx(7.989687).margin(2e-6));

  in.failed_submit = true;
  CHECK(trace_seq_reward(in).reward == -2);
  in.trace.success = true;  // applied last
  CHECK(trace_seq_reward(in).reward == 40);
}

TEST_CASE("Windows of TimedTransfer are those of the table", "[timed]") {
  constexpr int kTable[][3] = {{100, 95, 105},  {150, 142, 157}, {200, 190, 210},
                               {300, 285, 315}, {500, 475, 525}, {1000, 950, 1050}};
  for (const auto& [delay, start, end] : kTable) {
    for (int signal = 1; signal <= 3; ++signal) {
      const TimeWindow window = time_window(signal, delay);
      CHECK(window.start == signal + start);
      CHECK(window.end == signal + end);
    }
  }
}

TEST_CASE("The count of the example: D = 100, s = 2", "[timed]") {
  const TimeWindow window = time_window(2, 100);
  const auto phase = [&](int elapsed) { return count_phase(elapsed, 2, window); };
  CHECK_FALSE(phase(1).signal_on);
  CHECK_FALSE(phase(1).before_window);
  CHECK(phase(2).signal_on);
  CHECK(phase(2).before_window);
  CHECK(phase(96).before_window);
  CHECK_FALSE(phase(97).before_window);
  CHECK(phase(97).in_window);
  CHECK(phase(107).in_window);
  CHECK_FALSE(phase(108).in_window);
  CHECK(phase(108).past_window);
}

TEST_CASE("TimedTransfer rewards as in the worked example", "[timed]") {
  TransferRewardInputs in;
  in.count = count_phase(100, 2, time_window(2, 100));
  in.grasped = true;
  in.tcp_to_cube = 0.01;
  in.cube_to_goal = 0.12;
  in.arm_speed = 0.4;
  in.smooth_penalty = example_penalty();
  const double reward = transfer_reward(in).reward;
  CHECK(reward == Approx(14.013066).margin(2e-6));
  CHECK(reward / kTimedTransferSuccessReward == Approx(0.467102).margin(1e-6));

  in.on_red = true;
  CHECK(transfer_reward(in).reward == Approx(reward + 5 + 3 * (1 - std::tanh(2.0))).margin(1e-9));
  in.count = count_phase(50, 2, time_window(2, 100));
  CHECK(transfer_reward(in).reward == Approx(1.800664 + 3 - 5 - 0.046606).margin(2e-6));
  in.count = count_phase(1, 2, time_window(2, 100));
  CHECK(transfer_reward(in).reward == 0);  // before the signal, the penalty too
  in.success = true;
  CHECK(transfer_reward(in).reward == 30);
  in.failed = true;  // applied last
  CHECK(transfer_reward(in).reward == -25);
}

}  // namespace
}  // namespace engram::tasks
