#include "mjcf/disc.h"

#include <catch2/catch.hpp>

namespace engram::mjcf {
namespace {

TEST_CASE("A disc looks round and collides as a square of its height", "[mjcf][disc]") {
  const Prop prop = disc("disc", 0.1, 0.005, {1, 1, 1, 1});
  REQUIRE(prop.geoms.size() == 2);
  CHECK(prop.body_type == BodyType::kKinematic);
  CHECK(prop.geoms[0].type == GeomType::kCylinder);
  CHECK_FALSE(prop.geoms[0].collides);
  CHECK(prop.geoms[1].type == GeomType::kBox);
  CHECK_FALSE(prop.geoms[1].visible);
  CHECK(prop.geoms[1].size == Vec3{0.1, 0.1, 0.005});
  CHECK(prop.quat == kDiscQuat);
}

}  // namespace
}  // namespace engram::mjcf
