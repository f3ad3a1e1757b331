#include "tasks/common/tour.h"

#include <catch2/catch.hpp>

#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using tasks::Tour;

constexpr double kHeight = 0.06;  // m, of stops
const Eigen::Vector3d kRight(0.05, -0.1, kHeight);
const Eigen::Vector3d kMiddle(0.05, 0, kHeight);
const Eigen::Vector3d kLeft(0.05, 0.1, kHeight);

// A robot that stands where it is put, and a tour over three stops, not added in order.
struct Rig {
  std::unique_ptr<Batch> batch;
  Tour tour;

  Rig() {
    batch = test::make_env("RememberColor3-Long-VLA-v0", {.substeps = 0});
    batch->reset();
    for (const Eigen::Vector3d& stop : {kMiddle, kLeft, kRight}) tour.add(stop);
  }

  Tour::Target next(const Eigen::Vector3d& tool, double speed = 0, bool again = false) const {
    test::step_at(*batch, tool);
    batch->state().qvel.row(0)[0] = speed;
    return tour.next(batch->state(), 0, {.again = again});
  }
};

TEST_CASE("A tour begins at the nearest stop and goes on in one sense", "[parts][tour]") {
  const Rig rig;
  const auto is_over = [](const Eigen::Vector3d& goal, const Eigen::Vector3d& stop) {
    return (goal - stop).head<2>().norm() < 0.02 && goal.z() >= stop.z();
  };
  CHECK(is_over(rig.next({0.05, -0.07, 0.2}).goal, kRight));
  CHECK(is_over(rig.next({0.05, 0.02, 0.2}).goal, kMiddle));
  CHECK(rig.next(kRight).goal == kMiddle);
  CHECK(rig.next({0.05, -0.05, kHeight}).goal == kMiddle);
  CHECK(rig.next(kMiddle).goal == kLeft);
}

TEST_CASE("A tool comes to rest at every stop, and stays at the last", "[parts][tour]") {
  const Rig rig;
  CHECK(rig.next(kMiddle, 0.5).rest);
  CHECK_FALSE(rig.next(kMiddle, 0).rest);
  CHECK_FALSE(rig.next({0.05, -0.05, kHeight}, 0.5).rest);
  CHECK(rig.next(kLeft).rest);
  CHECK(rig.next(kLeft).goal == kLeft);
}

TEST_CASE("A tour without rests begins before the middle and passes its stops", "[parts][tour]") {
  const Rig rig;
  const auto next = [&rig](const Eigen::Vector3d& tool) {
    test::step_at(*rig.batch, tool);
    rig.batch->state().qvel.row(0)[0] = 0.5;
    return rig.tour.next(rig.batch->state(), 0, {.rests = false});
  };
  const auto is_at = [](const Eigen::Vector3d& goal, const Eigen::Vector3d& stop) {
    return (goal - stop).head<2>().norm() < 0.02;
  };
  for (const double y : {-0.1, 0.0, 0.1}) CHECK(is_at(next({0.05, y, 0.2}).goal, kRight));
  // A fast tool goes on at once, to a point beyond the next stop.
  const Tour::Target passing = next(kRight);
  CHECK(is_at(passing.goal, kMiddle));
  CHECK(passing.goal.y() > kMiddle.y());
  CHECK_FALSE(passing.rest);
  CHECK(is_at(next({0.05, -0.05, kHeight}).goal, kMiddle));
  CHECK(is_at(next(kMiddle).goal, kLeft));
  CHECK(next(kLeft).rest);
}

TEST_CASE("Tours that are repeated rise first, and go the other way every other time",
          "[parts][tour]") {
  const Rig rig;
  // The first one: up for some steps, then from the right end to the left one.
  CHECK(rig.next(kMiddle, 0, true).goal.z() > 0.13);
  while (rig.next(kMiddle, 0, true).goal.z() > 0.13) CHECK(rig.batch->state().elapsed[0] < 20);
  CHECK(rig.next(kMiddle, 0, true).goal == kLeft);
  // The second one.
  while (rig.next(kMiddle, 0, true).goal.z() < 0.13) CHECK(rig.batch->state().elapsed[0] < 100);
  while (rig.next(kMiddle, 0, true).goal.z() > 0.13) CHECK(rig.batch->state().elapsed[0] < 120);
  CHECK(rig.next(kMiddle, 0, true).goal == kRight);
}

}  // namespace
}  // namespace engram
