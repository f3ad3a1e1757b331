// GatherAndRecall with other constants: what follows from each, and sets that are refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/batch/queries.h"
#include "tests/tasks/variants/constant_text.h"
#include "tests/tasks/variants/moved_props.h"

namespace engram {
namespace {

using Catch::Contains, test::flag;

constexpr const char* kOne = "GatherAndRecall1-VLA-v0";
constexpr const char* kThree = "GatherAndRecall3-VLA-v0";

std::vector<Pin> pins() { return {{"disc_x", {0.04}}, {"disc_y", {0.14}}}; }

TEST_CASE("Cubes are as many as their number says", "[variants][gather]") {
  for (const int cubes : {1, 4, 9}) {
    const ConstantTable constants = {{"N_CUBES", cubes}, {"max_episode_steps", 800}};
    const auto task = make_task(kThree, constants);
    const TaskInfo& info = task->info();
    CHECK(test::draw_of(info, "cube_jitter").width == 2 * cubes);
    CHECK(test::draw_of(info, "flash_trigger_count").high == std::max(1, cubes - 1));
    CHECK(test::constant_text(info, "N_CUBES") == std::to_string(cubes));
    CHECK_THAT(task->document(), Contains("gather_cube_" + std::to_string(cubes - 1)) &&
                                     !Contains("gather_cube_" + std::to_string(cubes)));
    const auto batch = test::make_still(kThree, constants, pins());
    CHECK(batch->state_dim() == 41 + 8 * cubes);
    // All of them have to be on the disc, and each is worth its share of 10.
    float before = 0;
    for (int cube = 0; cube < cubes; ++cube) {
      CHECK_FALSE(flag(*batch, "all_on_disc"));
      test::step_with(*batch, cube, 0.04, 0.14, 0.026);
      const int counted = *test::row<std::int32_t>(batch->output("n_on_disc"), 0);
      CHECK(counted == cube + 1);
      CHECK(batch->outputs().reward[0] > before + 9.9F / static_cast<float>(cubes) - 2);
      before = batch->outputs().reward[0];
    }
    CHECK(flag(*batch, "all_on_disc"));
  }
}

TEST_CASE("The lamp flashes as long as its range says", "[variants][gather]") {
  for (const int duration : {1, 40}) {
    const auto batch = test::make_still(kOne, {{"FLASH_DURATION_STEPS", duration}}, pins());
    test::step_with(*batch, 0, 0.04, 0.14, 0.026);
    int lit = 0;
    for (; flag(*batch, "flash_active"); ++lit) test::step(*batch, Policy::kZero);
    CHECK(lit == duration);
    CHECK(Queries(*batch).cue_end(0) == 1 + duration);
  }
  const auto task = make_task(kOne, {{"FLASH_DURATION_STEPS", ConstantList{30, 50}}});
  CHECK(test::draw_of(task->info(), "flash_duration").low == 30);
  CHECK(test::draw_of(task->info(), "flash_duration").high == 50);
  CHECK(test::draw_of(task->info(), "flash_duration").constant == "FLASH_DURATION_STEPS");
}

TEST_CASE("The disc is as large as its radius says", "[variants][gather]") {
  for (const double radius : {0.04, 0.08, 0.16}) {
    const auto task = make_task(kOne, {{"DISC_RADIUS", radius}});
    CHECK(test::size_in(task->document(), "target_disc") == radius);
    CHECK(std::stod(test::constant_text(task->info(), "DISC_RADIUS")) == radius);
  }
}

TEST_CASE("A cube is on the disc as near as the threshold says", "[variants][gather]") {
  for (const double threshold : {0.015, 0.06, 0.2}) {
    const auto batch = test::make_still(kOne, {{"DISC_ON_THRESH", threshold}}, pins());
    test::step_with(*batch, 0, 0.04, 0.14 - threshold - 1e-6, 0.026);
    CHECK_FALSE(flag(*batch, "all_on_disc"));
    test::step_with(*batch, 0, 0.04, 0.14 - threshold + 1e-6, 0.026);
    CHECK(flag(*batch, "all_on_disc"));
  }
}

TEST_CASE("Coefficients of GatherAndRecall weigh the action cost", "[variants][gather]") {
  CHECK(test::dense_reward_of(kOne, {{"ACTION_L2_COEF", 0.11}}) ==
        Approx(test::dense_reward_of(kOne, {}) - 0.1 * std::tanh(2.0)).margin(1e-5));
}

TEST_CASE("GatherAndRecall refuses discs without room for the cubes, and horizons without time",
          "[variants][gather]") {
  CHECK_THROWS_WITH(make_task(kThree, {{"DISC_RADIUS", 0.06}}),
                    Contains("72 mm") && Contains("60 mm"));
  CHECK_THROWS_WITH(make_task(kThree, {{"DISC_ON_THRESH", 0.05}}),
                    Contains("52 mm + 11 mm") && Contains("50 mm"));
  CHECK_NOTHROW(make_task(kOne, {{"DISC_ON_THRESH", 0.05}, {"DISC_RADIUS", 0.05}}));
  CHECK_THROWS_WITH(make_task(kThree, {{"N_CUBES", 9}}),
                    Contains("675 + 25 to act = 700 control steps") && Contains("400"));
  CHECK_THROWS_WITH(make_task(kThree, {{"N_CUBES", 10}}), Contains("1 to 9"));
}

}  // namespace
}  // namespace engram
