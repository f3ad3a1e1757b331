// Documents as text.
#include "protocol/json.h"

#include <catch2/catch.hpp>
#include <limits>

namespace engram {
namespace {

TEST_CASE("JSON: constants as text", "[json]") {
  const ConstantTable table = {
      {"truths", ConstantList{true, false}},
      {"numbers", ConstantList{-7, 1.0, 0.1, 1e-9, 1e30}},
      {"no number", std::numeric_limits<double>::infinity()},
      {"text", "a \"quoted\" line\nand \xff"},
      {"nothing", ConstantList{}},
      {"table", ConstantTable{{"of nothing", ConstantTable{}}, {"\t", 2}}},
  };
  CHECK(to_text(table) == R"({
  "truths": [
    true,
    false
  ],
  "numbers": [
    -7,
    1.0,
    0.1,
    1e-09,
    1e+30
  ],
  "no number": null,
  "text": "a \"quoted\" line\nand �",
  "nothing": [],
  "table": {
    "of nothing": {},
    "\t": 2
  }
}
)");
  CHECK(to_text(table) == to_text(to_json(table)));
  CHECK(to_text(ConstantList{}) == "[]\n");
  CHECK(to_text(Constant(3)) == "3\n");
}

}  // namespace
}  // namespace engram
