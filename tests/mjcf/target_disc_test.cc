#include "mjcf/target_disc.h"

#include <catch2/catch.hpp>

namespace engram::mjcf {
namespace {

TEST_CASE("A target has five rings that shrink, alternate and do not collide",
          "[mjcf][target_disc]") {
  const Rgba red = {1, 0, 0, 1};
  const Prop prop = target_disc("target", 0.1, red);
  REQUIRE(prop.geoms.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) {
    const Geom& ring = prop.geoms[i];
    CHECK(ring.size[0] == Approx(0.02 * static_cast<double>(5 - i)));
    CHECK(ring.rgba == (i % 2 == 0 ? red : Rgba{1, 1, 1, 1}));
    CHECK_FALSE(ring.collides);
    CHECK_FALSE(ring.hidden_from_sensors);
    if (i == 0) continue;
    const Geom& below = prop.geoms[i - 1];
    CHECK(ring.pos[2] + ring.size[1] > below.pos[2] + below.size[1]);
  }
  CHECK(target_disc("target", 0.1, red, true).geoms[0].hidden_from_sensors);
}

}  // namespace
}  // namespace engram::mjcf
