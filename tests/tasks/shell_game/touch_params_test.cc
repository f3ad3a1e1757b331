#include "tasks/shell_game/touch_params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("The oracle's touch is within GOAL_THRESH of a mug's origin", "[shell]") {
  tasks::TouchParams params;
  CHECK(params.touch_gap() < params.GOAL_THRESH);
  const double gap = params.touch_gap();
  params.GOAL_THRESH = 0.065;
  CHECK(params.touch_gap() == Approx(0.06));
  params.GOAL_THRESH = 0.15;
  CHECK(params.touch_gap() == gap);
}

TEST_CASE("Touch games are refused where a touch is out of reach, or ambiguous", "[shell]") {
  tasks::TouchParams params;
  CHECK_NOTHROW(params.check(30));
  CHECK_THROWS_WITH(params.check(10), Catch::Contains("constants leave no time to act"));
  params.GOAL_THRESH = 0.01;
  CHECK_THROWS_WITH(params.check(30), Catch::Contains("constant 'GOAL_THRESH': 0.01 given"));
  params.GOAL_THRESH = 0.2;
  CHECK_THROWS_WITH(params.check(30), Catch::Contains("a tool over one cup would touch the next"));
}

}  // namespace
}  // namespace engram
