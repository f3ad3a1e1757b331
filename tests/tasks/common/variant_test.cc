#include "tasks/common/variant.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

namespace engram {
namespace {

struct Params {
  TaskSpec task;
  int COUNT;
};
constexpr std::array<Params, 2> kVariants = {{{{"One-v0", 20}, 1}, {{"Two-v0", 30}, 2}}};

TEST_CASE("A family finds the row of an id", "[variants]") {
  CHECK(tasks::find_variant(kVariants, "Two-v0").COUNT == 2);
  CHECK_THROWS_WITH(tasks::find_variant(kVariants, "Three-v0"), "no variant for Three-v0");
}

TEST_CASE("Every task has the common constants last, unpublished", "[variants]") {
  const auto task = make_task("TakeItBack-VLA-v0", {{"max_episode_steps", 90}});
  const std::vector<TaskConstant>& constants = task->info().constants;
  REQUIRE(constants.size() > 2);
  const TaskConstant& horizon = constants[constants.size() - 2];
  CHECK(horizon.name == kHorizonConstant);
  CHECK(horizon.value == Constant(90));
  CHECK(horizon.changed);
  CHECK_FALSE(horizon.published);
  CHECK(constants.back().name == kNoiseConstant);
  CHECK(task->info().horizon == 90);
  CHECK_FALSE(task->info().canonical);
}

}  // namespace
}  // namespace engram
