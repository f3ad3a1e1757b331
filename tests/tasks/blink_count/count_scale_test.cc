// The clock of the policy without memory.
#include "tasks/blink_count/count_scale.h"

#include <catch2/catch.hpp>
#include <cmath>

namespace engram::tasks {
namespace {

TEST_CASE("A scale counts blinks by the length of the cue", "[blink_count]") {
  const CountScale hard(kBlinkVariants[4]);  // 1 to 7 blinks of 7 steps, 7.5 steps before them
  CHECK(hard.count_after(0) == 1);
  CHECK(hard.count_after(14) == 1);
  CHECK(hard.count_after(22) == 2);
  CHECK(hard.count_after(50) == 6);
  CHECK(hard.count_after(500) == 7);
}

TEST_CASE("The places of counts are distinguished", "[blink_count]") {
  for (const BlinkCountParams& params : kBlinkVariants) {
    const CountScale scale(params);
    for (int count = params.BLINK_COUNT_RANGE.low; count <= params.BLINK_COUNT_RANGE.high;
         ++count) {
      const double offset = scale.offset_of(count);
      CHECK(std::abs(offset) < params.button.BUTTON_PRESS_XY_RADIUS);
      for (const double off : {-0.003, 0.0, 0.003}) CHECK(scale.count_at(offset + off) == count);
    }
    CHECK(scale.count_at(1) == params.BLINK_COUNT_RANGE.low);
    CHECK(scale.count_at(-1) == params.BLINK_COUNT_RANGE.high);
  }
}

TEST_CASE("A scale of one count shows that", "[blink_count]") {
  BlinkCountParams params = kBlinkVariants[0];
  params.BLINK_COUNT_RANGE = {2, 2};
  const CountScale scale(params);
  CHECK(scale.count_after(30) == 2);
  CHECK(scale.offset_of(2) == 0);
  CHECK(scale.count_at(0.01) == 2);
}

}  // namespace
}  // namespace engram::tasks
