// Islands are solved by themselves: the rest of the scene does not change a bit of their motion.
#include "core/contact/islands.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Placement;
using test::Rig;

// Physical state of a prop.
std::vector<double> motion_of(const State& state, int prop) {
  std::vector<double> numbers;
  const auto append = [&](const double* from, int count) {
    numbers.insert(numbers.end(), from, from + count);
  };
  append(state.prop_pos_of(0, prop), 3);
  append(state.prop_quat_of(0, prop), 4);
  append(state.prop_qvel_of(0, prop), 6);
  append(state.prop_qacc_warmstart.row(0) + 6 * prop, 6);
  append(state.finger_force.row(0) + 6 * prop, 6);
  return numbers;
}

std::vector<double> motion_of_robot(const State& state) {
  std::vector<double> numbers(state.qpos.row(0), state.qpos.row(0) + kRobotJoints);
  numbers.insert(numbers.end(), state.qvel.row(0), state.qvel.row(0) + kRobotJoints);
  return numbers;
}

Placement tumbling(double x, double y) {
  return {{x, y, 0.1}, PropStatus::kAwake, Eigen::Quaterniond(0.9, 0.3, -0.2, 0.1).normalized()};
}

Placement hidden() { return {{0.3, 0.6, 0.02}, PropStatus::kHidden}; }

BatchOptions options(bool sleep) {
  BatchOptions result;
  result.sleep = sleep;
  return result;
}

TEST_CASE("Props far apart move as each would alone, to the bit", "[physics][islands]") {
  const bool sleep = GENERATE(true, false);
  const Placement left = tumbling(-0.1, 0.3);
  const Placement right = tumbling(0.1, -0.3);
  Rig both = Rig::cubes({left, right}, options(sleep));
  Rig first = Rig::cubes({left, hidden()}, options(sleep));
  Rig second = Rig::cubes({hidden(), right}, options(sleep));
  for (int step = 0; step < 60; ++step) {
    for (Rig* rig : {&both, &first, &second}) rig->rest(1);
    REQUIRE(motion_of(both.state(), 0) == motion_of(first.state(), 0));
    REQUIRE(motion_of(both.state(), 1) == motion_of(second.state(), 1));
  }
  CHECK(both.pos(0).z() < 0.03);
}

TEST_CASE("A held prop moves the same, to the bit, whatever other props do", "[physics][islands]") {
  const bool sleep = GENERATE(true, false);
  const Eigen::Vector3d place(-0.1, 0.1, 0.02);
  Rig busy = Rig::cubes({{place}, tumbling(0.1, -0.3), tumbling(0.2, -0.3)}, options(sleep));
  Rig calm = Rig::cubes({{place}, hidden(), hidden()}, options(sleep));
  const auto move = [&](const Eigen::Vector3d& goal, int steps, double gripper) {
    for (int step = 0; step < steps; ++step) {
      for (Rig* rig : {&busy, &calm}) rig->move(goal, 1, gripper);
      REQUIRE(motion_of(busy.state(), 0) == motion_of(calm.state(), 0));
      REQUIRE(motion_of_robot(busy.state()) == motion_of_robot(calm.state()));
    }
  };
  move(place + Eigen::Vector3d(0, 0, 0.08), 25, tasks::kGripperOpen);
  move(place, 15, tasks::kGripperOpen);
  move(place, 8, -1);
  move(place + Eigen::Vector3d(0, 0, 0.15), 20, -1);
  CHECK(busy.pos(0).z() > 0.1);
}

}  // namespace
}  // namespace engram
