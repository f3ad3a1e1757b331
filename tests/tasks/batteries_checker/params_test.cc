#include "tasks/batteries_checker/params.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <utility>

namespace engram {
namespace {

TaskInfo described(int batteries, int working) {
  tasks::BatteryParams params = tasks::kEasyVariants[2];
  params.ACTIVE_BATTERY_COUNT = batteries;
  params.WORKING_BATTERY_COUNT = working;
  TaskInfo info;
  tasks::describe_batteries(params, info);
  return info;
}

// Counts all ways to take one of n batteries n times: the share in which all of the first w are
// taken, and that in which the last of them is taken before any battery is taken twice.
std::pair<double, double> count_ways(int batteries, int working) {
  const int ways = static_cast<int>(std::lround(std::pow(batteries, batteries)));
  int found = 0;
  int found_in_time = 0;
  for (int way = 0; way < ways; ++way) {
    unsigned taken = 0;
    bool repeated = false;
    bool in_time = false;
    for (int round = 0, rest = way; round < batteries; ++round, rest /= batteries) {
      const unsigned one = 1U << static_cast<unsigned>(rest % batteries);
      repeated = repeated || (taken & one) != 0;
      taken |= one;
      const unsigned all = (1U << static_cast<unsigned>(working)) - 1;
      in_time = in_time || (!repeated && (taken & all) == all);
      if (round == batteries - 1 && (taken & all) == all) ++found;
    }
    if (in_time) ++found_in_time;
  }
  return {static_cast<double>(found) / ways, static_cast<double>(found_in_time) / ways};
}

TEST_CASE("A guess is right as often as random rounds find all that work", "[batteries]") {
  for (const auto& [batteries, working] : {std::pair{3, 1}, {3, 3}, {5, 2}, {6, 3}, {1, 1}}) {
    INFO(working << " of " << batteries);
    const TaskInfo info = described(batteries, working);
    const auto [found, in_time] = count_ways(batteries, working);
    CHECK(info.guess_rate == Approx(found));
    CHECK(info.answer_rate == Approx(in_time));
  }
}

TEST_CASE("With check_all a guess checks all batteries in n! of n^n cases", "[batteries]") {
  TaskInfo info;
  tasks::describe_chance(tasks::kEasyVariants[2], true, info);  // three batteries
  CHECK(info.guess_rate == Approx(6.0 / 27));
  CHECK(info.answer_rate == info.guess_rate);
}

TEST_CASE("Candidates are the sets of batteries that may work", "[batteries]") {
  CHECK(described(3, 1).candidates == 3);
  CHECK(described(6, 3).candidates == 20);
  CHECK(described(15, 9).candidates == 5005);
  CHECK(described(4, 4).candidates == 1);
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
