#include "tasks/common/colors.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Published colours are the shortest decimals of single precision", "[parts]") {
  const ConstantList expected = {0.1, 0.5, 1.0, 1.0};
  CHECK(tasks::published_color({0.1, 0.5, 1, 1}) == Constant(expected));
}

TEST_CASE("The colour table is published by key", "[parts]") {
  const Constant table = tasks::color_mapping_constant();
  const auto& rows = std::get<ConstantTable>(table.value);
  REQUIRE(rows.size() == tasks::COLOR_MAPPING.size());
  CHECK(rows[3].first == "3");
  CHECK(rows[3].second == Constant(ConstantList{"Yellow", ConstantList{255, 255, 0, 255}}));
}

}  // namespace
}  // namespace engram
