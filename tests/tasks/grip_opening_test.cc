// Where the fingers stand while they hold something, beside measurements of the original.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "core/sim/state.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

struct Grips {
  std::vector<double> opening;  // of a finger, mm
  std::vector<double> speed;    // as it is reported, mm/s
};

bool holds_a_prop(const State& state, int env) {
  for (int prop = 0; prop < state.num_props; ++prop) {
    if (is_grasping(state, env, prop)) return true;
  }
  return false;
}

// Grips in all control steps of eight episodes in which something is held firmly.
Grips oracle_grips(const std::string& id) {
  const auto batch = test::make_running(id, {.num_envs = 8});
  const State& state = batch->state();
  Grips grips;
  std::vector<double> before(8, 0);
  for (int step = 0; step < batch->info().horizon; ++step) {
    test::step(*batch, Policy::kOracle);
    for (int i = 0; i < 8; ++i) {
      const double* finger = state.qpos.row(i) + kArmJoints;
      const bool still = std::abs(finger[0] - before[static_cast<std::size_t>(i)]) < 1e-4;
      before[static_cast<std::size_t>(i)] = finger[0];
      if (!still || !holds_a_prop(state, i)) continue;
      for (int k = 0; k < kFingers; ++k) {
        grips.opening.push_back(1e3 * finger[k]);
        grips.speed.push_back(1e3 * std::abs(state.qvel.row(i)[kArmJoints + k]));
      }
    }
  }
  return grips;
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

TEST_CASE("Fingers that hold something stand where the original's do", "[physics][original]") {
  struct Measured {
    const char* id;
    double opening;  // mm
  };
  constexpr double kTolerance = 0.1;  // mm
  for (const auto& [id, opening] : {Measured{"TimedTransferEasy-VLA-v0", 18.27},
                                    {"GatherAndRecall1-VLA-v0", 18.28},
                                    {"TraceShapeHard-VLA-v0", 18.27},
                                    {"BatteriesCheckerEasy-3-VLA-v0", 8.61},
                                    {"ShellGamePick-VLA-v0", 7.72},
                                    {"InterceptGrabSlow-VLA-v0", 17.71},
                                    {"InterceptGrabFast-VLA-v0", 17.71}}) {
    const Grips grips = oracle_grips(id);
    INFO(id);
    REQUIRE(grips.opening.size() > 20);
    INFO(median(grips.opening) << " mm, at " << median(grips.speed) << " mm/s");
    CHECK(median(grips.opening) == Approx(opening).margin(kTolerance));
  }
}

}  // namespace
}  // namespace engram
