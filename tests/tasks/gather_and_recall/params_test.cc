#include "tasks/gather_and_recall/params.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Places on the disc are apart", "[gather]") {
  for (int one = 0; one < tasks::kMaxCubes; ++one) {
    for (int other = 0; other < one; ++other) {
      const tasks::Vec2 offset = tasks::place_on_disc(one) - tasks::place_on_disc(other);
      CHECK(offset.cwiseAbs().maxCoeff() > 2 * tasks::CUBE_HALF_SIZE);
    }
  }
}

TEST_CASE("The flash begins before the last cube is placed, if there are several", "[gather]") {
  CHECK(tasks::max_triggers(1) == 1);
  CHECK(tasks::max_triggers(2) == 1);
  CHECK(tasks::max_triggers(9) == 8);
}

TEST_CASE("Cubes need room on the disc, and time", "[gather]") {
  tasks::GatherParams params = tasks::kGatherVariants[4];
  CHECK_NOTHROW(params.check(1000));
  CHECK_THROWS_WITH(params.check(600), Catch::Contains("N_CUBES x 75 to gather 675"));
  params.DISC_RADIUS = 0.05;
  CHECK_THROWS_WITH(params.check(1000), Catch::Contains("beyond DISC_RADIUS 50 mm"));
}

}  // namespace
}  // namespace engram
