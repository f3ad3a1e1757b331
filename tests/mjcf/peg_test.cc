#include "mjcf/peg.h"

#include <catch2/catch.hpp>

namespace engram::mjcf {
namespace {

TEST_CASE("A peg is one solid box with two halves of a colour each", "[mjcf][peg]") {
  const Prop prop = peg("peg", 0.1, 0.02, {1, 0, 0, 1}, {0, 0, 1, 1});
  REQUIRE(prop.geoms.size() == 3);
  CHECK(prop.geoms[0].collides);
  CHECK_FALSE(prop.geoms[0].visible);
  CHECK(prop.geoms[1].pos[0] == -0.05);
  CHECK(prop.geoms[1].rgba == Rgba{1, 0, 0, 1});
  CHECK(prop.geoms[2].pos[0] == 0.05);
  CHECK(prop.geoms[2].rgba == Rgba{0, 0, 1, 1});
  CHECK(prop.mass == Approx(1000 * 0.2 * 0.04 * 0.04));
  CHECK(prop.inertia[0] == Approx(prop.mass / 6 * 0.04 * 0.04));
  CHECK(prop.inertia[1] == Approx(prop.mass / 12 * (0.2 * 0.2 + 0.04 * 0.04)));
  CHECK(prop.pos[2] == 0.02);
}

}  // namespace
}  // namespace engram::mjcf
