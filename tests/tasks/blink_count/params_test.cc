#include "tasks/blink_count/params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("The latest start is that of the longest cue", "[blink_count]") {
  const tasks::BlinkCountParams easy = tasks::kBlinkVariants[0];
  CHECK(easy.latest_start() == 10 + 3 * (3 + 5));
  CHECK(easy.steps_per_press() == 11);
}

TEST_CASE("Two buttons stand apart, and no place is over both", "[blink_count]") {
  tasks::BlinkCountParams params = tasks::kBlinkVariants[0];
  CHECK_NOTHROW(params.check(150));
  params.button.BUTTON_PRESS_XY_RADIUS = 0.1;
  CHECK_THROWS_WITH(params.check(150), Catch::Contains("constant 'BUTTON_PRESS_XY_RADIUS'"));
}

}  // namespace
}  // namespace engram
