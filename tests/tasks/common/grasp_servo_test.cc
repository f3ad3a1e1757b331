// Grasping, carrying and releasing, on real physics.
#include "tasks/common/grasp_servo.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/random.h"
#include "mjcf/disc.h"
#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Rig;
using namespace tasks;

constexpr double kOnDisc = 0.026;  // m

// A cube on the table, and a disc.
Rig make_rig(double cube_yaw = 0, const BatchOptions& options = {}) {
  std::vector<mjcf::Prop> props = {mjcf::cube("cube", 0.02, {1, 0, 0, 1}),
                                   mjcf::disc("disc", 0.07, 0.003, {0, 1, 0, 1})};
  const Eigen::Quaterniond turned(Eigen::AngleAxisd(cube_yaw, Eigen::Vector3d::UnitZ()));
  const mjcf::Quat& q = mjcf::kDiscQuat;
  return Rig(
      std::move(props),
      {{{-0.1, -0.1, 0.02}, PropStatus::kAsleep, turned},
       {{0.0, 0.15, 0.003}, PropStatus::kAsleep, Eigen::Quaterniond(q[0], q[1], q[2], q[3])}},
      options);
}

Grip grip(const Rig& rig) { return {.prop = 0, .tool = cube_grasp_orientation(rig.state(), 0, 0)}; }

// Steps until the cube is held.
int take_cube(Rig& rig) {
  std::array<float, 7> action{};
  for (int step = 0; step < 100; ++step) {
    if (grasp(rig.state(), 0, grip(rig), action.data())) return step;
    rig.batch().step(action);
  }
  return -1;
}

// Carries the held cube towards a place for N steps.
void carry_for(Rig& rig, int steps, const Eigen::Vector3d& place) {
  std::array<float, 7> action{};
  for (int i = 0; i < steps; ++i) {
    carry(rig.state(), 0, grip(rig), place, action.data());
    rig.batch().step(action);
  }
}

TEST_CASE("A cube is taken however it is turned", "[grasp]") {
  for (const double yaw : {0.0, 0.3, 0.75, 0.82, 1.5, -2.0}) {
    Rig rig = make_rig(yaw);
    INFO(yaw);
    CHECK(take_cube(rig) > 0);
    CHECK(is_held(rig.state(), 0, 0));
  }
}

// Position of the cube in the hand's frame, m.
Eigen::Vector3d in_hand(const Rig& rig) {
  const double* q = rig.state().tcp_quat.row(0);
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() * (rig.pos(0) - rig.tcp());
}

TEST_CASE("A cube in the oracle's grip does not slip in 200 steps", "[grasp]") {
  Rig rig = make_rig();
  REQUIRE(take_cube(rig) > 0);
  const Eigen::Vector3d place(-0.1, 0.1, 0.1);
  carry_for(rig, 40, place);
  REQUIRE(rig.pos(0).z() == Approx(0.1).margin(0.002));
  const Eigen::Vector3d before = in_hand(rig);
  carry_for(rig, 200, place);
  CHECK(is_held(rig.state(), 0, 0));
  CHECK((in_hand(rig) - before).norm() < 5e-5);
}

TEST_CASE("A held cube slips less than 0.1 mm in 60 random steps", "[grasp][original]") {
  for (const double scale : {0.5, 1.0}) {
    Rig rig = make_rig();
    REQUIRE(take_cube(rig) > 0);
    carry_for(rig, 40, {-0.1, 0.0, 0.25});
    std::array<float, 7> action{};
    const Eigen::Vector3d before = in_hand(rig);
    RandomStream random(11, 1, 0);
    double slip = 0;
    for (int i = 0; i < 60; ++i) {
      for (std::size_t k = 0; k < 6; ++k) {
        action[k] = static_cast<float>(scale * random.uniform(-1, 1));
      }
      action[6] = static_cast<float>(kGripperSqueezing);
      rig.batch().step(action);
      slip = std::max(slip, (in_hand(rig) - before).norm());
    }
    INFO("scale " << scale << ": " << 1e3 * slip << " mm");
    CHECK(is_held(rig.state(), 0, 0));
    CHECK(slip < 1e-4);
  }
}

TEST_CASE("A cube is brought onto a disc, left there and rests", "[grasp]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  Rig rig = make_rig(0.4, options);
  const Eigen::Vector3d place(0.02, 0.14, kOnDisc);
  std::array<float, 7> action{};
  int steps = 0;
  while (steps < 200 && !pick_and_place(rig.state(), 0, grip(rig), place, action.data())) {
    rig.batch().step(action);
    ++steps;
  }
  CHECK(steps < 100);
  CHECK(is_at(rig.state(), 0, 0, place));
  CHECK(rig.tcp().z() > place.z() + 0.06);
  const Eigen::Vector3d left = rig.pos(0);
  INFO(left.transpose());
  rig.rest(200);
  INFO(rig.pos(0).transpose());
  CHECK((rig.pos(0) - left).norm() < 0.001);
  CHECK(rig.pos(0).z() == Approx(kOnDisc).margin(2e-4));
}

TEST_CASE("What was lost on the way is taken again", "[grasp]") {
  Rig rig = make_rig();
  REQUIRE(take_cube(rig) > 0);
  carry_for(rig, 10, {-0.1, 0.1, 0.05});
  rig.rest(15, kGripperOpen);
  CHECK_FALSE(is_held(rig.state(), 0, 0));
  CHECK(take_cube(rig) > 0);
}

}  // namespace
}  // namespace engram
