#include "core/task/task_constant.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

using Kind = TaskConstant::Kind;

TEST_CASE("One list of constants has views of the published and the changed ones", "[constants]") {
  const std::vector<TaskConstant> constants = {
      {.name = "COUNT", .kind = Kind::kInteger, .value = 7, .changed = true},
      {.name = "HEIGHT", .value = 1000.0},
      {.name = "threshold", .kind = Kind::kReal, .value = 0.1, .published = false},
      {.name = "SHAPES",
       .kind = Kind::kNames,
       .value = ConstantList{"circle"},
       .published_value = ConstantList{0}}};
  const ConstantTable published = {{"COUNT", 7}, {"HEIGHT", 1000.0}, {"SHAPES", ConstantList{0}}};
  CHECK(published_constants(constants) == published);
  CHECK(changed_constants(constants) == ConstantTable{{"COUNT", 7}});
  CHECK(constants[0].changeable());
  CHECK_FALSE(constants[1].changeable());
}

TEST_CASE("Constants are numbers, or read as words", "[constants]") {
  CHECK(as_number(Constant(3)) == 3.0);
  CHECK(as_number(Constant(0.5)) == 0.5);
  CHECK_FALSE(as_number(Constant("three")));
  CHECK(in_words(ConstantList{1, "two", true}) == "[1, 'two', true]");
}

}  // namespace
}  // namespace engram
