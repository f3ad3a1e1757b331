#include "bench/interleave.h"

#include <catch2/catch.hpp>
#include <string>

namespace engram::bench {
namespace {

TEST_CASE("Medians of odd and even counts", "[bench]") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 3, 2}) == 2.5);
}

TEST_CASE("A ratio is the median of the rounds' ratios", "[bench]") {
  Rounds rounds;
  rounds.add(1, 1);
  rounds.add(4, 2);
  rounds.add(9, 3);
  const Comparison result = rounds.result();
  CHECK(result.value == 4);
  CHECK(result.baseline == 2);
  CHECK(result.ratio == 2);
}

TEST_CASE("Both sides warm up once and then take turns in going first", "[bench]") {
  std::string order;
  double last = 0;
  SuiteOptions options;
  options.rounds = 2;
  options.progress = [&last](double fraction) {
    CHECK(fraction > last);
    last = fraction;
  };
  const auto side = [&order](char name, double value) {
    return [&order, name, value] {
      order += name;
      return value;
    };
  };
  const Comparison result = interleave(options, side('v', 6), side('b', 3), 1, 2);
  CHECK(order == "vbvbbv");
  CHECK(result.ratio == 2);
  CHECK(last == 1);
}

}  // namespace
}  // namespace engram::bench
