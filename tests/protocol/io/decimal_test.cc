#include "protocol/io/decimal.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Numbers have as many decimals as asked for", "[decimal]") {
  CHECK(decimal(1.0 / 3, 3) == "0.333");
  CHECK(decimal(2, 2) == "2.00");
  CHECK(decimal(-0.5, 1) == "-0.5");
  CHECK(decimal(123456.7, 0) == "123457");
}

}  // namespace
}  // namespace engram
