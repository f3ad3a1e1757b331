// Layout, flash and reward of GatherAndRecall in worked examples.
#include "tasks/gather_and_recall/reward.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

namespace engram::tasks {
namespace {

const Vec2 kDisc(0.04, 0.14);

TEST_CASE("Cubes stand in rows of three", "[gather]") {
  const std::vector<Vec2> five = {
      {-0.13, -0.305}, {-0.04, -0.305}, {0.05, -0.305}, {-0.085, -0.215}, {0.005, -0.215}};
  for (int cube = 0; cube < 5; ++cube) {
    const Vec2 place = cluster_place(cube, 5, 0.02, kDisc);
    CHECK((place - five[static_cast<std::size_t>(cube)]).norm() < 1e-12);
  }
  for (int cube = 0; cube < 9; ++cube) {
    const Vec2 expected(-0.13 + 0.09 * (cube % 3), -0.35 + 0.09 * (cube / 3));
    CHECK((cluster_place(cube, 9, 0.02, kDisc) - expected).norm() < 1e-12);
  }
  CHECK((cluster_place(0, 1, 0.02, kDisc) - Vec2(-0.04, -0.26)).norm() < 1e-12);
}

TEST_CASE("A cube counts when it is near the disc's centre and slow", "[gather]") {
  const Eigen::Vector3d still(0, 0, 0);
  CHECK(is_on_disc({0.04, 0.239, 0.026}, still, kDisc));
  CHECK_FALSE(is_on_disc({0.04, 0.2401, 0.026}, still, kDisc));
  CHECK(is_on_disc({0.04, 0.14, 0.4}, still, kDisc));  // carried
  CHECK_FALSE(is_on_disc({0.04, 0.14, 0.5}, still, kDisc));
  CHECK(is_on_disc({0.04, 0.14, 0.1}, {0.1, 0.1, 0}, kDisc));
  CHECK_FALSE(is_on_disc({0.04, 0.14, 0.1}, {0.1, 0.1, 0.1}, kDisc));
}

TEST_CASE("The lamp flashes once, from the step that triggers it", "[gather]") {
  Flash flash;
  std::vector<int> lit;
  for (int elapsed = 0; elapsed < 300; ++elapsed) {
    const int cubes = elapsed < 120 ? 1 : 2;
    if (update_flash(flash, cubes, 2, 8, elapsed)) lit.push_back(elapsed);
  }
  CHECK(lit == std::vector<int>{120, 121, 122, 123, 124, 125, 126, 127});
}

TEST_CASE("The gathering reward's examples", "[gather][reward]") {
  GatherReward in{
      .goal_distance = 0.25,
      .cubes = 5,
      .cubes_on_disc = 2,
      .action_cost = {.action_norm = 1.593738, .action_delta_norm = 1.593738, .arm_speed = 0.4}};
  CHECK(in.compute() == Approx(4.025338).margin(1e-6));
  CHECK(in.smooth.penalty == Approx(0.046606).margin(1e-6));
  in.correct_depth = 0.5;  // pressing too early is worth nothing
  CHECK(in.compute() == Approx(4.025338).margin(1e-6));
  in.all_on_disc = true;
  CHECK(in.compute() == Approx(4.025338 + 1.5 * 0.071945 + 2.5).margin(1e-6));
  in.failed = true;
  CHECK(in.compute() == -25);
  in.success = true;
  CHECK(in.compute() == 50);
}

}  // namespace
}  // namespace engram::tasks
