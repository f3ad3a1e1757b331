#include "mjcf/panda_collision.h"

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
