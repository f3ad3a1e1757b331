// TakeItBack with other constants: what follows from each, and sets that are refused.
#include <catch2/catch.hpp>
#include <cmath>

#include "tasks/take_it_back/task.h"
#include "tests/tasks/variants/constant_text.h"
#include "tests/tasks/variants/moved_props.h"

namespace engram {
namespace {

using Catch::Contains;

constexpr const char* kId = "TakeItBack-VLA-v0";
constexpr int kCube = 0;

TEST_CASE("Target and start are as forgiving as their radius says", "[variants][take_it_back]") {
  for (const double radius : {0.02, 0.05, 0.1}) {
    const ConstantTable constants = {{"GOAL_RADIUS", radius}};
    const std::string document = make_task(kId, constants)->document();
    for (const char* disc : {"initial_region", "goal_region", "changed_goal_region"}) {
      CHECK(test::size_in(document, disc) == radius);
    }
    const auto batch = test::make_still(kId, constants,
                                        {{"slot", {0}},
                                         {"initial_x", {0.0}},
                                         {"initial_shift", {0.02}},
                                         {"goal_x", {0.22}},
                                         {"goal_y", {0.02}}});
    const auto reached = [&] {
      return *test::row<std::uint8_t>(batch->output("goal_reached_status"), 0) != 0;
    };
    CHECK_FALSE(test::succeeds_with(*batch, kCube, 0.22, 0.02 + radius + 1e-6, 0.02));
    CHECK_FALSE(reached());
    CHECK_FALSE(test::succeeds_with(*batch, kCube, 0.22, 0.02 + radius - 1e-6, 0.02));
    CHECK(reached());
    CHECK_FALSE(test::succeeds_with(*batch, kCube, 0, 0.02 + radius + 1e-6, 0.02));
    CHECK(test::succeeds_with(*batch, kCube, 0, 0.02 + radius - 1e-6, 0.02));
    CHECK(batch->outputs().reward[0] == 30);
  }
}

TEST_CASE("Start and target keep two radii apart", "[variants][take_it_back]") {
  const MakeOptions options{{.num_envs = 1000}, {{"GOAL_RADIUS", 0.1}}};
  const auto batch = test::make_running(kId, options);
  double least = 9;
  for (int i = 0; i < options.num_envs; ++i) {
    using Vec2 = Eigen::Map<const Eigen::Vector2d>;
    const Vec2 start(test::row<double>(test::memory_of(*batch).find("initial"), i));
    const Vec2 target(test::row<double>(test::memory_of(*batch).find("goal"), i));
    least = std::min(least, (start - target).norm());
  }
  CHECK((least >= 0.2 && least < 0.205));
}

TEST_CASE("The larger the start, the luckier are guesses", "[variants][take_it_back]") {
  const auto chance = [](double radius) {
    return make_task(kId, {{"GOAL_RADIUS", radius}})->info().chance();
  };
  // As often as the blind policy succeeded, in 4000 and four times 1500 episodes.
  CHECK(make_task(kId)->info().chance() == Approx(0.406).margin(0.02));
  CHECK(chance(0.02) == Approx(0.167).margin(0.02));
  CHECK(chance(0.04) == Approx(0.295).margin(0.02));
  CHECK(chance(0.06) == Approx(0.355).margin(0.02));
  CHECK(chance(0.1) == Approx(0.537).margin(0.05));
}

TEST_CASE("The cube is as large and as heavy as its size says", "[variants][take_it_back]") {
  for (const double half : {0.01, 0.015, 0.03}) {
    const ConstantTable constants = {{"CUBE_HALFSIZE", half}};
    const std::string document = make_task(kId, constants)->document();
    CHECK(test::size_in(document, "cube") == half);
    CHECK(test::mass_in(document, "cube") == Approx(8000 * half * half * half));
    CHECK(test::make_still(kId, constants)->state().prop_pos_of(0, kCube)[2] == half);
  }
  tasks::TakeItBackReward in{.tcp = {-0.035, 0, 0}, .cube_halfsize = 0.03};
  in.compute();
  CHECK(in.push_distance == Approx(0).margin(1e-12));
  in.tcp = {0.04, 0, 0};
  in.compute();
  CHECK(in.pull_distance == Approx(0).margin(1e-12));
}

TEST_CASE("Coefficients of TakeItBack weigh the action cost", "[variants][take_it_back]") {
  const float free = test::dense_reward_of(
      kId, {{"ACTION_L2_COEF", 0}, {"ACTION_DELTA_L2_COEF", 0}, {"QVEL_L2_COEF", 0}});
  const float usual = test::dense_reward_of(kId, {});
  // The first action is no change, and without physics nothing moves.
  CHECK(usual == Approx(free - 0.01 * std::tanh(2.0)).margin(1e-6));
}

TEST_CASE("TakeItBack refuses what leaves no time, and cubes that no hand can hold",
          "[variants][take_it_back]") {
  CHECK_THROWS_WITH(make_task(kId, {{"max_episode_steps", 44}}),
                    Contains("45 to act = 45 control steps"));
  CHECK_NOTHROW(make_task(kId, {{"max_episode_steps", 45}}));
  CHECK_THROWS_WITH(make_task(kId, {{"CUBE_HALFSIZE", 0.05}}), Contains("0.01 to 0.03"));
  CHECK_THROWS_WITH(make_task(kId, {{"GOAL_RADIUS", 0.2}}), Contains("0.02 to 0.1"));
}

}  // namespace
}  // namespace engram
