#include "tasks/common/action_cost.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram {
namespace {

constexpr tasks::SmoothnessParams kWeights = {
    .ACTION_L2_COEF = 0.01, .ACTION_DELTA_L2_COEF = 0.05, .QVEL_L2_COEF = 0.02};

TEST_CASE("The smoothness penalty weighs saturated norms", "[parts][reward]") {
  const tasks::SmoothnessTerms terms = tasks::smoothness(
      {.action_norm = 0.5, .action_delta_norm = 0.1, .arm_speed = 0.25}, kWeights);
  CHECK(terms.action_l2 == Approx(std::tanh(1.0)));
  CHECK(terms.action_delta_l2 == Approx(std::tanh(0.5)));
  CHECK(terms.qvel_l2 == Approx(std::tanh(0.5)));
  CHECK(terms.penalty ==
        Approx(0.01 * std::tanh(1.0) + 0.05 * std::tanh(0.5) + 0.02 * std::tanh(0.5)));
}

TEST_CASE("A robot at rest without an action costs nothing", "[parts][reward]") {
  CHECK(tasks::smoothness({}, kWeights).penalty == 0);
}

}  // namespace
}  // namespace engram
