#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/apps/command.h"

namespace engram::test {

TEST_CASE("bench: rows of a suite", "[apps]") {
  const ParsedJson rows = engram_command("bench create --rounds 1 --json").json();
  REQUIRE(!rows.empty());
  for (const ParsedJson& row : rows) {
    CHECK(keys_of(row) == std::vector<std::string>{"name", "value", "unit", "baseline",
                                                   "baseline_value", "ratio", "rounds"});
  }
}

}  // namespace engram::test
