#include "mjcf/panda_collision.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>

#include "tests/mjcf/model.h"

namespace engram::mjcf::test {
namespace {

TEST_CASE("Every link has the collision geoms that it names", "[mjcf][panda]") {
  const Model model = compile({}, Detail::kRobotOnly);
  int geoms = 0;
  for (int i = 0; i < kLinkCount; ++i) {
    const auto link = static_cast<Link>(i);
    const int body = id(model, mjOBJ_BODY, link_name(link));
    CHECK(model->body_geomnum[body] == collision_geom_count(link));
    for (int k = 0; k < collision_geom_count(link); ++k, ++geoms) {
      CHECK(model->geom_bodyid[id(model, mjOBJ_GEOM, collision_geom_name(link, k))] == body);
    }
  }
  CHECK(model->ngeom == geoms + 1);  // and the table's plane
}

// Extents of its hull, in the hand's frame.
TEST_CASE("The hand has the extents of the original's", "[mjcf][panda][original]") {
  const Model model = compile({}, Detail::kRobotOnly);
  std::array<double, 3> low{};
  std::array<double, 3> high{};
  for (int k = 0; k < collision_geom_count(Link::kHand); ++k) {
    const int geom = id(model, mjOBJ_GEOM, collision_geom_name(Link::kHand, k));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double middle = model->geom_pos[3 * static_cast<std::size_t>(geom) + axis];
      const double half = model->geom_size[3 * static_cast<std::size_t>(geom) + axis];
      low[axis] = std::min(low[axis], middle - half);
      high[axis] = std::max(high[axis], middle + half);
    }
  }
  const std::array<double, 3> expected_low = {-0.0316, -0.104, -0.0259};
  const std::array<double, 3> expected_high = {0.0316, 0.1004, 0.06596};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    CHECK(low[axis] == Approx(expected_low[axis]).margin(2e-4));
    CHECK(high[axis] == Approx(expected_high[axis]).margin(2e-4));
  }
}

TEST_CASE("The right finger mirrors the left", "[mjcf][panda]") {
  const Model model = compile({}, Detail::kRobotOnly);
  REQUIRE(collision_geom_count(Link::kRightFinger) == collision_geom_count(Link::kLeftFinger));
  for (int k = 0; k < collision_geom_count(Link::kLeftFinger); ++k) {
    const mjtNum* left =
        model->geom_pos + 3 * id(model, mjOBJ_GEOM, collision_geom_name(Link::kLeftFinger, k));
    const mjtNum* right =
        model->geom_pos + 3 * id(model, mjOBJ_GEOM, collision_geom_name(Link::kRightFinger, k));
    CHECK(left[0] == right[0]);
    CHECK(left[1] == -right[1]);
    CHECK(left[2] == right[2]);
  }
}

}  // namespace
}  // namespace engram::mjcf::test
