#include "tasks/common/touch_latch.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

namespace engram::tasks {
namespace {

// Touch points of cubes at rest at (0, 0) and beside it.
int touch(double x, double z, double radius, double neighbour = 1) {
  const double points[6] = {0, 0, 0.045, neighbour, 0, 0.045};
  const double tcp[3] = {x, 0, z};
  return touched_object(points, 2, tcp, radius);
}

TEST_CASE("A touch is a matter of the distance to the touch point", "[touch]") {
  for (const double radius : {0.05, 0.02}) CHECK(touch(0, 0.055, radius) == 0);
  CHECK(touch(0, 0.070, 0.05) == 0);
  CHECK(touch(0, 0.070, 0.02) == -1);
  CHECK(touch(0, 0.090, 0.05) == 0);
  CHECK(touch(0, 0.090, 0.02) == -1);
  CHECK(touch(0, 0.100, 0.05) == -1);
  CHECK(touch(0.030, 0.045, 0.05) == 0);
  CHECK(touch(0.030, 0.045, 0.02) == -1);
  CHECK(touch(0.05 - 1e-12, 0.045, 0.05) == 0);
  CHECK(touch(0.05 + 1e-12, 0.045, 0.05) == -1);
}

TEST_CASE("Between two cubes only the nearer one is touched", "[touch]") {
  CHECK(touch(0.039, 0.045, 0.05, 0.08) == 0);
  CHECK(touch(0.041, 0.045, 0.05, 0.08) == 1);
  CHECK(touch(0.040, 0.045, 0.05, 0.08) == 0);  // as near: the lower number
}

TEST_CASE("First touches are noted in order, and one too many overwrites the first", "[touch]") {
  std::array<std::int32_t, 3> order = {-1, -1, -1};
  using Order = std::array<std::int32_t, 3>;
  append_touch(order.data(), 3, 4);
  CHECK(order == Order{4, -1, -1});
  append_touch(order.data(), 3, 1);
  append_touch(order.data(), 3, 7);
  CHECK(order == Order{4, 1, 7});
  append_touch(order.data(), 3, 3);
  CHECK(order == Order{3, 1, 7});
}

}  // namespace
}  // namespace engram::tasks
