#include "core/sim/state.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/collision/contact_pair.h"
#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

TEST_CASE("A placed prop has its pose and no velocity, force or contact", "[state]") {
  const test::MixedColumns columns;
  const State& state = columns.state;
  std::fill_n(state.prop_qvel_of(0, 1), 6, 1.0);
  state.finger_force.row(0)[6 + 2] = 5;
  ContactPair touching;
  touching.shape_pair = 0;
  touching.manifold.known = true;
  touching.num_patches = 1;
  std::int32_t* const ids = state.contact_ids.row(0);
  store_pair(touching, 1, -1, ids, state.contact_values.row(0));
  store_pair(touching, 2, 0, ids + StoredPair::kInts,
             state.contact_values.row(0) + StoredPair::kFloats);
  state.prop_slow_steps.row(0)[1] = 4;
  columns.place(0, 1, {1, 2, 3}, PropStatus::kAwake);
  CHECK(state.prop_pos_of(0, 1)[2] == 3);
  CHECK(state.prop_quat_of(0, 1)[0] == 1);
  CHECK(std::all_of(state.prop_qvel_of(0, 1), state.prop_qvel_of(0, 1) + 6,
                    [](double v) { return v == 0; }));
  CHECK(state.finger_force.row(0)[6 + 2] == 0);
  // The pair stays in the order of solving; that of other props stays as it was.
  CHECK_FALSE(StoredPair::is_empty(ids));
  CHECK(ids[StoredPair::kPoints] == 0);
  CHECK(ids[StoredPair::kPatches] == 0);
  CHECK(ids[StoredPair::kInts + StoredPair::kPoints] == 1);
  CHECK(ids[StoredPair::kInts + StoredPair::kPatches] == 1);
  CHECK(state.prop_slow_steps.row(0)[1] == 0);
  CHECK(state.status_of(0, 1) == PropStatus::kAwake);
}

TEST_CASE("A kinematic motion is a displacement from where the prop is", "[state]") {
  const test::MixedColumns columns;
  const double target[3] = {-0.1, 0.5, 0.03};
  columns.state.move_kinematic(0, test::kBox, target);
  CHECK(columns.state.prop_qvel_of(0, test::kBox)[0] == Approx(0.1));
  CHECK(columns.state.prop_qvel_of(0, test::kBox)[2] == Approx(0.01));
  CHECK(columns.state.prop_pos_of(0, test::kBox)[0] == -0.2);
  CHECK(columns.state.status_of(0, test::kBox) == PropStatus::kAwake);
}

TEST_CASE("A hidden prop reports the position that it is given", "[state]") {
  const test::MixedColumns columns;
  const double reported[3] = {0, 0, 1000};
  columns.state.hide_prop(0, test::kCube0, reported);
  CHECK(columns.state.status_of(0, test::kCube0) == PropStatus::kHidden);
  CHECK(columns.state.prop_pos_of(0, test::kCube0)[2] == 1000);
}

TEST_CASE("Robot and props are static up to their thresholds", "[state]") {
  const test::MixedColumns columns;
  const State& state = columns.state;
  CHECK(robot_is_static(state, 0));
  state.qvel.row(0)[3] = -0.21;
  CHECK_FALSE(robot_is_static(state, 0));
  CHECK(robot_is_static(state, 0, 0.3));
  state.qvel.row(0)[3] = 0;
  state.qvel.row(0)[kArmJoints] = 1;  // a finger
  CHECK(robot_is_static(state, 0));

  CHECK(prop_is_static(state, 0, 0));
  state.prop_qvel_of(0, 0)[1] = 0.011;
  CHECK_FALSE(prop_is_static(state, 0, 0));
  state.prop_qvel_of(0, 0)[1] = 0;
  state.prop_qvel_of(0, 0)[4] = 0.2;
  CHECK_FALSE(prop_is_static(state, 0, 0));
  CHECK(prop_is_static(state, 0, 0, 1e-2, 0.3));
}

TEST_CASE("A grasp needs force on both fingers, along their opening directions", "[state]") {
  const test::MixedColumns columns;
  const State& state = columns.state;
  state.tcp_quat.row(0)[0] = 1;
  double* force = state.finger_force.row(0) + 6 * test::kCube0;
  CHECK_FALSE(is_grasping(state, 0, test::kCube0));
  force[1] = 1;
  CHECK_FALSE(is_grasping(state, 0, test::kCube0));
  force[4] = -1;
  CHECK(is_grasping(state, 0, test::kCube0));
  CHECK_FALSE(is_grasping(state, 0, test::kCube0, 2.0));
  CHECK_FALSE(is_grasping(state, 0, test::kBall));
  force[0] = 20;  // nearly across the opening direction
  CHECK_FALSE(is_grasping(state, 0, test::kCube0));
}

}  // namespace
}  // namespace engram
