#include "protocol/eval/run/mean.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Means of numbers and of truths", "[evaluation]") {
  CHECK(mean(std::vector<double>{1, 2, 6}) == 3);
  CHECK(mean(std::vector<bool>{true, false, false, true}) == 0.5);
  CHECK(mean(std::vector<int>{}) == 0);
}

}  // namespace
}  // namespace engram
