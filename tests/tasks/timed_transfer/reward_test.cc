// Counting and rewards of TimedTransfer in worked examples.
#include "tasks/timed_transfer/reward.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace engram::tasks {
namespace {

// Delay, first and last step of the window after the signal.
using Windows = std::vector<std::array<int, 3>>;

void check_windows(const Windows& windows, WindowRounding rounding) {
  for (const auto& [delay, start, end] : windows) {
    INFO(delay);
    for (int signal = 1; signal <= 3; ++signal) {
      const TimeWindow window = time_window(signal, delay, TOLERANCE_FRAC, rounding);
      CHECK(window.start == signal + start);
      CHECK(window.end == signal + end);
    }
  }
}

TEST_CASE("Windows of TimedTransfer are five per cent to either side", "[timed]") {
  check_windows({{100, 95, 105},
                 {150, 143, 157},
                 {200, 190, 210},
                 {300, 285, 315},
                 {500, 475, 525},
                 {1000, 950, 1050},
                 {70, 67, 73},
                 {130, 124, 136}},
                WindowRounding::kInward);
}

TEST_CASE("Windows of the original's code are rounded down at both ends", "[timed]") {
  check_windows({{100, 95, 105},
                 {150, 142, 157},
                 {200, 190, 210},
                 {300, 285, 315},
                 {500, 475, 525},
                 {1000, 950, 1050},
                 {70, 66, 73}},
                WindowRounding::kDown);
}

TEST_CASE("A window has all steps within the tolerance, and no others", "[timed]") {
  for (int delay = 60; delay <= 3000; delay += 7) {
    for (int percent = 0; percent <= 50; ++percent) {
      INFO(delay << " steps, " << percent << " per cent");
      const TimeWindow window = time_window(0, delay, percent / 100.0);
      const int early = delay - window.start;
      const int late = window.end - delay;
      CHECK((100 * early <= delay * percent && 100 * (early + 1) > delay * percent));
      CHECK(late == early);
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
  TransferReward in{.tcp_to_cube = 0.01,
                    .cube_to_goal = 0.12,
                    .count = count_phase(100, 2, time_window(2, 100)),
                    .grasped = true};
  // The first action of an episode, a change from zeros.
  in.action_cost = {.action_norm = 1.593738, .action_delta_norm = 1.593738, .arm_speed = 0.4};
  const double reward = in.compute();
  CHECK(reward == Approx(14.013066).margin(2e-6));
  CHECK(reward / kTimedTransferSuccessReward == Approx(0.467102).margin(1e-6));

  in.on_red = true;
  CHECK(in.compute() == Approx(reward + 5 + 3 * (1 - std::tanh(2.0))).margin(1e-9));
  in.count = count_phase(50, 2, time_window(2, 100));
  CHECK(in.compute() == Approx(1.800664 + 3 - 5 - 0.046606).margin(2e-6));
  in.count = count_phase(1, 2, time_window(2, 100));
  CHECK(in.compute() == 0);  // before the signal, the penalty too
  in.success = true;
  CHECK(in.compute() == 30);
  in.failed = true;  // applied last
  CHECK(in.compute() == -25);
}

}  // namespace
}  // namespace engram::tasks
