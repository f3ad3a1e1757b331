#include "tasks/common/constant_forms.h"

#include <catch2/catch.hpp>

namespace engram::tasks {
namespace {

TEST_CASE("Values are the same in single precision, whatever their type", "[constants]") {
  CHECK(is_same_value(3, 3.0));
  CHECK(is_same_value(0.065, static_cast<double>(0.065F)));
  CHECK_FALSE(is_same_value(0.065, 0.0651));
  CHECK(is_same_value(ConstantList{1, 2.0}, ConstantList{1.0, 2}));
  CHECK_FALSE(is_same_value(ConstantList{1}, ConstantList{1, 1}));
  CHECK_FALSE(is_same_value(ConstantList{1}, 1));
  const ConstantTable table = {{"0", "red"}, {"1", 2}};
  CHECK(is_same_value(table, ConstantTable{{"1", 2.0}, {"0", "red"}}));
  CHECK_FALSE(is_same_value(table, ConstantTable{{"1", 2.0}, {"2", "red"}}));
  CHECK(is_same_value("red", "red"));
  CHECK_FALSE(is_same_value("red", nullptr));
}

TEST_CASE("Colours have names, and those without one are numbers", "[constants]") {
  CHECK(as_color("maroon") == mjcf::Rgba{128 / 255.0, 0, 0, 1});
  CHECK(as_color("Olive") == as_color("olive"));
  CHECK_FALSE(as_color("pink").has_value());
  CHECK(as_color(ConstantList{0.5, 0, 1}) == mjcf::Rgba{0.5, 0, 1, 1});
  CHECK_FALSE(as_color(ConstantList{0.5, 0, 1, 0.2}).has_value());
  CHECK_FALSE(as_color(ConstantList{0.5, 0, 2}).has_value());
  CHECK(kept_color({0, 1, 0, 1}) == Constant("green"));
  CHECK(kept_color({0.1, 1, 0, 1}) == Constant(ConstantList{0.1, 1.0, 0.0}));
}

TEST_CASE("Values without another form stay as they are", "[constants]") {
  TaskConstant about;
  about.kind = TaskConstant::Kind::kReal;
  CHECK(kept_form(about, 7) == Constant(7));
  about.kind = TaskConstant::Kind::kNames;
  about.names = {"cube", "star"};
  CHECK(kept_form(about, 1) == Constant(ConstantList{"star"}));
  CHECK(kept_form(about, ConstantList{2, 0}) == Constant(ConstantList{2, "cube"}));
  const Constant gap = ConstantTable{{"0", "cube"}, {"2", "star"}};
  CHECK(kept_form(about, gap) == gap);
}

}  // namespace
}  // namespace engram::tasks
