#include "apps/output.h"

#include <catch2/catch.hpp>
#include <limits>

namespace engram::apps {
namespace {

TEST_CASE("Tables align their columns", "[apps][output]") {
  Table table({{"name"}, {"value", true}});
  CHECK(table.empty());
  table.add({"a", "1"});
  table.add({"longer", "1,234,567"});
  CHECK_FALSE(table.empty());
  CHECK(table.text() ==
        "name        value\n"
        "a               1\n"
        "longer  1,234,567\n");
}

TEST_CASE("Lines of tables are indented and have no blanks at their end", "[apps][output]") {
  Table table({{"a"}, {"b"}});
  table.add({"1", ""});
  CHECK(table.text("  ") == "  a  b\n  1\n");
}

TEST_CASE("Thousands are separated", "[apps][output]") {
  CHECK(with_thousands(0) == "0");
  CHECK(with_thousands(999.4) == "999");
  CHECK(with_thousands(31234567.8) == "31,234,568");
  CHECK(with_thousands(-1000) == "-1,000");
  CHECK(with_thousands(std::numeric_limits<double>::quiet_NaN()) == "-");
}

}  // namespace
}  // namespace engram::apps
