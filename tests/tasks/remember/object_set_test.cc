#include "tasks/remember/object_set.h"

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "mjcf/object_shapes.h"
#include "tasks/remember/object_recall.h"

namespace engram::tasks {
namespace {

std::vector<int> identity(const ObjectSet& objects, int key) {
  return {objects.identity(key).begin(), objects.identity(key).end()};
}

TEST_CASE("Keys of shapes and colours go through the colours first", "[object_set]") {
  const char* const shapes[] = {"cube", "sphere", "t_shape", "cross", "torus"};
  const mjcf::Rgba colors[] = {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}};
  for (const int count : {6, 9, 15}) {
    const ObjectSet objects({Vocabulary::kShapeAndColor, count});
    REQUIRE(objects.count() == count);
    for (int key = 0; key < count; ++key) {
      CHECK(identity(objects, key) == std::vector<int>{key / 3, key % 3});
      const mjcf::Prop& prop = objects.prop(key);
      CHECK(prop.name == shapes[key / 3] + ("_" + std::to_string(key)));
      for (const mjcf::Primitive& part : prop.primitives) CHECK(part.rgba == colors[key % 3]);
    }
  }
}

TEST_CASE("Keys of shapes and keys of colours are their ids", "[object_set]") {
  const char* const shapes[] = {"cube", "sphere",   "cylinder", "cross",   "torus",
                                "star", "pyramide", "t_shape",  "crescent"};
  const double heights[] = {0.02, 0.02, 0.02, 0.0075, 0.00765367, 0.0075, 0.005, 0.0075, 0.0028463};
  const ObjectSet objects({Vocabulary::kShape, 9});
  for (int key = 0; key < 9; ++key) {
    const auto index = static_cast<std::size_t>(key);
    CHECK(identity(objects, key) == std::vector<int>{key});
    CHECK(objects.prop(key).name == shapes[index] + ("_" + std::to_string(key)));
    CHECK(objects.prop(key).primitives[0].rgba == mjcf::Rgba{0, 0, 1, 1});
    CHECK(objects.resting_height(key) == Approx(heights[index]).margin(1e-8));
  }
  const ObjectSet cubes({Vocabulary::kColor, 9});
  CHECK(identity(cubes, 7) == std::vector<int>{7});
  CHECK(cubes.prop(7).name == "cube_7");
  CHECK(cubes.prop(7).primitives[0].rgba == mjcf::Rgba{1, 128 / 255.0, 0, 1});
  CHECK(cubes.resting_height(7) == 0.02);
}

TEST_CASE("Only shapes and colours together go without a penalty", "[object_set]") {
  CHECK(default_smoothness(Vocabulary::kColor).ACTION_L2_COEF == 0.02);
  CHECK(default_smoothness(Vocabulary::kShape).ACTION_DELTA_L2_COEF == 0.05);
  const SmoothnessParams none = default_smoothness(Vocabulary::kShapeAndColor);
  CHECK(none.ACTION_L2_COEF == 0);
  CHECK(none.ACTION_DELTA_L2_COEF == 0);
  CHECK(none.QVEL_L2_COEF == 0);
}

}  // namespace
}  // namespace engram::tasks
