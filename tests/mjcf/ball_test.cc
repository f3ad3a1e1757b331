#include "mjcf/ball.h"

#include <catch2/catch.hpp>
#include <numbers>

namespace engram::mjcf {
namespace {

TEST_CASE("A ball is a solid sphere on the table", "[mjcf][ball]") {
  const Prop prop = ball("ball", 0.03, {1, 0, 0, 1});
  const double mass = 1000 * 4.0 / 3 * std::numbers::pi * 0.03 * 0.03 * 0.03;
  CHECK(prop.mass == Approx(mass));
  for (std::size_t i = 0; i < 3; ++i) CHECK(prop.inertia[i] == Approx(0.4 * mass * 0.03 * 0.03));
  CHECK(prop.pos[2] == 0.03);
  CHECK(prop.body_type == BodyType::kDynamic);
  CHECK(prop.damping == Approx(0.05 * prop.inertia[0]));
}

}  // namespace
}  // namespace engram::mjcf
