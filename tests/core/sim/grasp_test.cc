// Predicates of the state, and a real grasp.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/sim/state.h"
#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Rig;

TEST_CASE("The robot is static up to and including the threshold", "[state]") {
  ColumnStore store(1);
  const State state(store, 0);
  CHECK(robot_is_static(state, 0));
  for (int joint = 0; joint < kArmJoints; ++joint) {
    for (const double sign : {-1.0, 1.0}) {
      state.qvel.row(0)[joint] = sign * 0.2;
      CHECK(robot_is_static(state, 0));
      state.qvel.row(0)[joint] = sign * std::nextafter(0.2, 1.0);
      CHECK_FALSE(robot_is_static(state, 0));
      CHECK(robot_is_static(state, 0, 0.3));
      state.qvel.row(0)[joint] = 0;
    }
  }
  state.qvel.row(0)[7] = state.qvel.row(0)[8] = 1;  // fingers do not count
  CHECK(robot_is_static(state, 0));
}

TEST_CASE("A prop is static up to and including both thresholds", "[state]") {
  ColumnStore store(1);
  const State state(store, 2);
  double* qvel = state.prop_qvel_of(0, 1);
  CHECK(prop_is_static(state, 0, 1));
  qvel[1] = -0.01;
  qvel[4] = 0.1;
  CHECK(prop_is_static(state, 0, 1));
  qvel[1] = -0.0101;
  CHECK_FALSE(prop_is_static(state, 0, 1));
  qvel[1] = 0;
  qvel[4] = 0.101;
  CHECK_FALSE(prop_is_static(state, 0, 1));
  qvel[4] = 0;
  qvel[0] = qvel[2] = 0.008;  // the norm counts, not the components
  CHECK_FALSE(prop_is_static(state, 0, 1));
  CHECK(prop_is_static(state, 0, 0));
  CHECK(prop_is_static(state, 0, 1, 0.02));
}

TEST_CASE("A grasp needs force and direction on both fingers", "[state]") {
  ColumnStore store(1);
  const State state(store, 2);
  // Tool down: the left finger opens towards -y of the world.
  const double down[4] = {0, 1, 0, 0};
  std::copy_n(down, 4, state.tcp_quat.row(0));
  double* left = state.finger_force.row(0) + 6;
  double* right = left + 3;
  const auto set = [&](double newtons, double degrees) {
    const double angle = degrees * std::numbers::pi / 180;
    left[0] = right[0] = newtons * std::sin(angle);
    left[1] = -newtons * std::cos(angle);
    right[1] = newtons * std::cos(angle);
  };
  CHECK_FALSE(is_grasping(state, 0, 1));
  set(0.5, 0);
  CHECK(is_grasping(state, 0, 1));
  CHECK_FALSE(is_grasping(state, 0, 0));  // that of another prop
  set(0.499, 0);
  CHECK_FALSE(is_grasping(state, 0, 1));
  CHECK(is_grasping(state, 0, 1, 0.4));
  set(10, 84.99);
  CHECK(is_grasping(state, 0, 1));
  set(10, 85.01);
  CHECK_FALSE(is_grasping(state, 0, 1));
  CHECK(is_grasping(state, 0, 1, 0.5, 86));
  CHECK_FALSE(is_grasping(state, 0, 1, 0.5, 80));
  set(10, 180);  // pulled inwards
  CHECK_FALSE(is_grasping(state, 0, 1));
  set(10, 0);
  right[1] = 0;  // one finger only
  CHECK_FALSE(is_grasping(state, 0, 1));
  set(10, 0);
  left[1] = 0;
  CHECK_FALSE(is_grasping(state, 0, 1));
  CHECK_FALSE(is_grasping(state, 0, 1, 0));  // no force has no direction
}

TEST_CASE("A grasped cube is lifted, held without slip and let go", "[physics]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  Rig rig = Rig::cubes({{{-0.05, 0.05, 0.02}}, {{0.05, -0.1, 0.02}}}, options);
  const auto grasping = [&] { return is_grasping(rig.state(), 0, 0); };
  rig.move({-0.05, 0.05, 0.12}, 20);
  rig.move({-0.05, 0.05, 0.02}, 20);
  CHECK_FALSE(grasping());
  rig.rest(10, -1);
  CHECK(grasping());
  CHECK_FALSE(is_grasping(rig.state(), 0, 1));

  int held = 0;
  for (int i = 0; i < 20; ++i) {
    rig.move({-0.05, 0.05, 0.20}, 1, -1);
    held += grasping() ? 1 : 0;
  }
  CHECK(held == 20);
  CHECK(rig.pos(0).z() > 0.15);

  const Eigen::Vector3d in_hand = rig.pos(0) - rig.tcp();
  held = 0;
  for (int i = 0; i < 40; ++i) {
    rig.rest(1, -1);
    held += grasping() ? 1 : 0;
  }
  CHECK(held == 40);
  CHECK((rig.pos(0) - rig.tcp() - in_hand).norm() < 0.001);

  rig.rest(20, 1);
  CHECK_FALSE(grasping());
  CHECK(rig.pos(0).z() == Approx(0.02).margin(0.0021));
}

TEST_CASE("A held cube slips less than 2 mm in 200 steps", "[physics]") {
  Rig rig = Rig::cubes({{{-0.05, 0.05, 0.02}}});
  rig.move({-0.05, 0.05, 0.02}, 40);
  rig.rest(10, -1);
  rig.move({-0.05, 0.05, 0.15}, 20, -1);
  const Eigen::Vector3d in_hand = rig.pos(0) - rig.tcp();
  rig.rest(200, -1);
  CHECK(is_grasping(rig.state(), 0, 0));
  CHECK((rig.pos(0) - rig.tcp() - in_hand).norm() < 0.002);
}

// 30 N of each drive; the original measures 27.95 and 27.97 N at the cube.
TEST_CASE("The force of a grip is the original's", "[physics]") {
  Rig rig = Rig::cubes({{{-0.05, 0.05, 0.02}}});
  rig.move({-0.05, 0.05, 0.02}, 30);
  rig.rest(20, -1);
  for (int finger = 0; finger < kFingers; ++finger) {
    const Eigen::Map<const Eigen::Vector3d> force(rig.state().finger_force.row(0) + 3 * finger);
    CHECK(force.norm() == Approx(27.96).margin(0.05));
    CHECK(std::abs(force.y()) > 0.99 * force.norm());
  }
}

TEST_CASE("Forces on the fingers end when a held cube vanishes", "[physics]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  Rig rig = Rig::cubes({{{-0.05, 0.05, 0.02}}}, options);
  const auto strongest = [&] {
    const double* force = rig.state().finger_force.row(0);
    return std::max(std::abs(force[1]), std::abs(force[4]));
  };
  rig.move({-0.05, 0.05, 0.02}, 30);
  rig.rest(10, -1);
  rig.move({-0.05, 0.05, 0.2}, 30, -1);
  REQUIRE(strongest() > 20);
  const double away[3] = {0.3, 0.6, 0.02};
  rig.task().engine.state->hide_prop(0, 0, away);
  rig.rest(1);
  CHECK(strongest() == 0);
}

}  // namespace
}  // namespace engram
