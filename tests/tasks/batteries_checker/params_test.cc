#include "tasks/batteries_checker/params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("A guess checks all batteries in n! of n^n cases", "[batteries]") {
  TaskInfo info;
  tasks::describe_batteries(tasks::kEasyVariants[2], info);  // three batteries
  CHECK(info.guess_rate == Approx(6.0 / 27));
  CHECK(info.answer_rate == info.guess_rate);
}

TEST_CASE("Batteries that work are among those to be tested", "[batteries]") {
  tasks::BatteryParams params = tasks::kEasyVariants[2];
  CHECK_NOTHROW(params.check(540));
  CHECK_THROWS_WITH(params.check(200), Catch::Contains("ACTIVE_BATTERY_COUNT 3 x 70 = 210"));
  params.WORKING_BATTERY_COUNT = 4;
  CHECK_THROWS_WITH(params.check(540), Catch::Contains("at most ACTIVE_BATTERY_COUNT 3 allowed"));
}

}  // namespace
}  // namespace engram
