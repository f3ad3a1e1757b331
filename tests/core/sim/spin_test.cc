// Slender props that tumble fast do not spin themselves up.
#include <Eigen/Core>
#include <catch2/catch.hpp>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

TEST_CASE("A battery that is thrown tumbles no faster and faster", "[physics]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  const auto batch = test::make_running("BatteriesCheckerHard-3-VLA-v0", options);
  const double pos[3] = {0, 0.5, 4};
  const double quat[4] = {1, 0, 0, 0};
  const State& state = batch->state();
  state.place_prop(0, 0, pos, quat, PropStatus::kAwake);
  // Velocity that a finger's flick has given one: rad/s about its own axes.
  const Eigen::Vector3d flick(34, 9, 72);
  Eigen::Map<Eigen::Vector3d> spin(state.prop_qvel_of(0, 0) + 3);
  spin = flick;
  for (int step = 0; step < 15; ++step) {
    test::step(*batch, Policy::kZero);
    INFO("step " << step);
    REQUIRE(Queries(*batch).unstable_count() == 0);
    REQUIRE(spin.norm() <= 100 + 1e-9);
  }
  CHECK(state.prop_pos_of(0, 0)[2] > 0.5);  // still in the air
  CHECK(spin.norm() > 10);
}

}  // namespace
}  // namespace engram
