// Documents and their texts.
#include "protocol/io/json.h"

#include <catch2/catch.hpp>
#include <limits>

namespace engram {
namespace {

TEST_CASE("Documents as text", "[document]") {
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
  CHECK(to_text(JsonList{}) == "[]\n");
  CHECK(to_text(Json(3)) == "3\n");
  CHECK(to_text(Json()) == "null\n");
  CHECK(is_null(Json()));
  CHECK_FALSE(is_null(JsonTable{}));
  CHECK(to_line(table) ==
        R"({"truths":[true,false],"numbers":[-7,1.0,0.1,1e-09,1e+30],"no number":null,)"
        R"("text":"a \"quoted\" line\nand �","nothing":[],"table":{"of nothing":{},"\t":2}})");
}

TEST_CASE("Texts as documents", "[document]") {
  for (const char* text : {R"({"a":[1,-2,18446744073709551615,0.5,1.0,true,null],"b":{"c":"d"}})",
                           "[]", "7", "null"}) {
    INFO(text);
    const std::optional<Json> document = parse_json(text);
    REQUIRE(document);
    CHECK(to_line(*document) == text);
    CHECK((parse_json(to_text(*document)) == document));
  }
  for (const char* text : {"", "{", "[1,]", "{\"a\":}", "7 8", "{1:2}", "nan"}) {
    INFO(text);
    CHECK_FALSE(parse_json(text));
  }
  CHECK(to_line(*parse_json(R"({"a":1,"b":2,"a":3})")) == R"({"a":3,"b":2})");
}

TEST_CASE("Texts that nest deeply are no documents", "[document]") {
  const auto nested = [](std::size_t levels) {
    return std::string(levels, '[') + std::string(levels, ']');
  };
  CHECK(parse_json(nested(64)));
  CHECK_FALSE(parse_json(nested(65)));
  CHECK_FALSE(parse_json(nested(1'000'000)));
}

TEST_CASE("Equal numbers make equal documents, whatever their type", "[document]") {
  CHECK((Json(5) == Json(5U)));
  CHECK((Json(5) == Json(std::uint64_t{5})));
  CHECK((Json(5) == parse_json("5")));
  CHECK((Json(UINT64_MAX) == parse_json("18446744073709551615")));
  CHECK_FALSE((Json(1) == Json(1.0)));  // a count is no measure
  CHECK_FALSE((Json(1) == Json(true)));
}

TEST_CASE("Parts of documents have the requested type, or an error names it", "[document]") {
  const Json document = JsonTable{{"count", 3}, {"name", "x"}, {"rate", 0.5}};
  CHECK(whole_number(part(document, "count"), 3) == 3);
  CHECK(number(part(document, "count")) == 3);
  CHECK(number(part(document, "rate")) == 0.5);
  CHECK(text(part(document, "name")) == "x");
  CHECK(find(document, "other") == nullptr);
  CHECK(find(Json(3), "count") == nullptr);
  CHECK_THROWS_WITH(part(document, "other"), "no 'other'");
  CHECK_THROWS_WITH(whole_number(part(document, "count"), 2),
                    "3 given, a whole number up to 2 needed");
  CHECK_THROWS_WITH(whole_number(-1, 2), "-1 given, a whole number up to 2 needed");
  CHECK_THROWS_WITH(whole_number(part(document, "rate")),
                    "0.5 given, a whole number up to 18446744073709551615 needed");
  CHECK_THROWS_WITH(number(part(document, "name")), "\"x\" given, a number needed");
  CHECK_THROWS_WITH(text(document), Catch::Contains("given, a text needed"));
  CHECK_THROWS_WITH(list(document), Catch::Contains("given, a list needed"));
  CHECK_THROWS_WITH(table(3), "3 given, a table needed");
  CHECK_THROWS_WITH(truth(1), "1 given, a truth needed");
}

}  // namespace
}  // namespace engram
