#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/apps/command.h"

namespace engram::tests {

TEST_CASE("bench: rows of a suite", "[apps]") {
  const Json rows = engram_command("bench create --rounds 1 --json").json();
  REQUIRE(!rows.empty());
  for (const Json& row : rows) {
    CHECK(keys_of(row) == std::vector<std::string>{"name", "value", "unit", "baseline",
                                                   "baseline_value", "ratio", "rounds"});
  }
}

}  // namespace engram::tests
