#include "protocol/make/variants.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram {
namespace {

using Catch::Contains;

TEST_CASE("Constants are read from a JSON object and from nothing else", "[variants]") {
  const ConstantTable constants = parse_constants(R"({"COLORS": 7, "STEPS": [3, 5]})");
  CHECK((constants == ConstantTable{{"COLORS", 7}, {"STEPS", ConstantList{3, 5}}}));
  CHECK(parse_constants("{}").empty());
  for (const char* text : {"", "7", "[]", "{", "x"}) {
    CHECK_THROWS_WITH(parse_constants(text), Contains("a JSON object"));
  }
}

TEST_CASE("A variant survives the way to JSON and back", "[variants]") {
  const TaskVariant variant = {
      "RememberColor7-Slow-v0", "RememberColor9-VLA-v0", {{"COLORS", 7}}, "Touch it."};
  CHECK(to_variant(to_document(variant), "test") == variant);
  const TaskVariant plain = {"RememberColor7-Slow-v0", "RememberColor9-VLA-v0", {}, ""};
  CHECK(find(to_document(plain), "instruction") == nullptr);
  CHECK(to_variant(to_document(plain), "test") == plain);
}

TEST_CASE("Documents that are no variants are refused by name", "[variants]") {
  const auto refuse = [](const char* json, const char* message) {
    CHECK_THROWS_WITH(to_variant(parse_json(json).value(), "file 'x'"),
                      Contains("file 'x'") && Contains(message));
  };
  refuse("7", "has to be a table");
  refuse(R"({"id": "a-v0"})", "a text 'base' needed");
  refuse(R"({"id": 1, "base": "b"})", "a text 'id' needed");
  refuse(R"({"id": "a-v0", "base": "b", "colour": 1})", "'colour', allowed are: id, base");
  refuse(R"({"id": "a-v0", "base": "b", "constants": 1})", "have to be a table");
}

TEST_CASE("Results name a variant where constants differ from the benchmark's", "[variants]") {
  const RegistryEntry& entry = require_entry("RememberColor9-VLA-v0");
  CHECK((variant_document(entry, {}) == Json(nullptr)));
  const Json changed = variant_document(entry, {{"COLORS", 7}});
  CHECK((part(changed, "base") == Json(entry.base)));
  CHECK((part(changed, "constants") == Json(JsonTable{{"COLORS", 7}})));
}

}  // namespace
}  // namespace engram
