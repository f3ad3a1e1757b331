#include "tasks/colors/cubes.h"

#include <algorithm>
#include <catch2/catch.hpp>

namespace engram {
namespace {

using tasks::ColorCubes;

TEST_CASE("Cubes are the scene's first props, one of each colour", "[color_recall]") {
  mjcf::Scene scene;
  const ColorCubes cubes(scene, tasks::kBunchVariants[0], tasks::VariableHandle(1));
  REQUIRE(scene.props.size() == 9);
  CHECK(scene.props[0].name == "cube_0");
  CHECK(scene.props[8].name == "cube_8");
}

TEST_CASE("Cubes that do not stand apart are refused", "[color_recall]") {
  mjcf::Scene scene;
  tasks::ColorRecallParams params = tasks::kBunchVariants[0];
  params.CUBE_HALFSIZE = 0.04;
  CHECK_THROWS_WITH(ColorCubes(scene, params, tasks::VariableHandle(1)),
                    Catch::Contains("larger cubes do not stand apart"));
}

TEST_CASE("Shuffled colours are a permutation", "[color_recall]") {
  tasks::ColorPermutation storage{};
  const auto colors = tasks::shuffled_colors(5, storage, RandomStream(1, 2, 3));
  REQUIRE(colors.size() == 5);
  for (int color = 0; color < 5; ++color) CHECK(std::ranges::count(colors, color) == 1);
}

}  // namespace
}  // namespace engram
