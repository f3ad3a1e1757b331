#include "core/sim/scene_binding.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/core/sim/columns_fixture.h"

namespace engram {
namespace {

using test::mixed_model;

// One environment's step on scenes that several may share.
struct Bound {
  Bound(const State& state, int env, SceneWorkspace& scenes)
      : step(mixed_model(), state, env, workspace, clearance, nullptr), binding(step, scenes) {}

  void begin(bool sleep = true) {
    binding.begin(sleep);
    binding.select_scene(step.smallest_scene(true));
  }
  void load() {
    JointArray qpos;
    std::copy_n(step.state.qpos.row(step.env), kRobotJoints, qpos.begin());
    binding.load(qpos, {});
  }

  StepWorkspace workspace{mixed_model()};
  RobotBounds::Clearance clearance;
  EnvStep step;
  SceneBinding binding;
};

TEST_CASE("Awake props are those of the columns, or without sleep all that are present",
          "[scene_binding]") {
  const test::MixedColumns columns;
  SceneWorkspace scenes(mixed_model());
  Bound bound(columns.state, 0, scenes);
  const bool sleep = GENERATE(true, false);
  bound.begin(sleep);
  CHECK(bound.step.is_awake(test::kCube0));
  CHECK(bound.step.is_awake(test::kBall) == !sleep);
  CHECK_FALSE(bound.step.is_awake(test::kCube1));
  CHECK(bound.step.num_awake == (sleep ? 1 : 2));
  CHECK(bound.step.scene->slots.size() == (sleep ? 1U : 2U));
}

TEST_CASE("A scene holds what the columns hold, and gives it back", "[scene_binding]") {
  const test::MixedColumns columns;
  SceneWorkspace scenes(mixed_model());
  Bound bound(columns.state, 0, scenes);
  bound.begin();
  bound.load();
  mjData& data = bound.step.data();
  const PropSlot& slot = bound.step.slot_of(test::kCube0);
  CHECK(data.qpos[3] == test::kStartPose[3]);
  CHECK(data.qpos[slot.qpos + 1] == 0.4);
  CHECK(data.qpos[slot.qpos + 3] == 1);
  CHECK(data.mocap_pos[3 * bound.step.scene->mocap[test::kBox]] == -0.2);

  data.qpos[slot.qpos + 2] = 0.07;
  data.qvel[slot.dof + 2] = -0.5;
  data.qacc_warmstart[slot.dof + 2] = -9;
  bound.binding.read_back();
  bound.step.contact_force[4] = 2;
  JointArray qpos{};
  JointArray qvel{};
  qpos[0] = 0.25;
  qvel[8] = -0.125;
  REQUIRE(bound.binding.is_plausible(qpos, qvel));
  bound.binding.store(qpos, qvel);
  const State& state = columns.state;
  CHECK(state.qpos.row(0)[0] == 0.25);
  CHECK(state.qvel.row(0)[8] == -0.125);
  CHECK(state.contact_force.row(0)[4] == 2);
  CHECK(state.prop_pos_of(0, test::kCube0)[2] == 0.07);
  CHECK(state.prop_qvel_of(0, test::kCube0)[2] == -0.5);
  CHECK(state.prop_qacc_warmstart.row(0)[2] == -9);
  CHECK(state.prop_pos_of(0, test::kBall)[0] == 0.1);
}

TEST_CASE("Environments that take turns on a scene find their own props", "[scene_binding]") {
  const test::MixedColumns columns(2);
  columns.place(1, test::kCube0, {0.05, 0.3, 0.2}, PropStatus::kAwake);
  SceneWorkspace scenes(mixed_model());
  Bound first(columns.state, 0, scenes);
  Bound second(columns.state, 1, scenes);
  first.begin();
  second.begin();
  REQUIRE(first.step.instance == second.step.instance);
  const auto height = [](const Bound& bound) {
    return bound.step.data().qpos[bound.step.slot_of(test::kCube0).qpos + 2];
  };
  for (int turn = 0; turn < 2; ++turn) {
    first.load();
    CHECK(height(first) == 0.1);
    second.load();
    CHECK(height(second) == 0.2);
  }
}

TEST_CASE("Empty slots are far from everything", "[scene_binding]") {
  const test::MixedColumns columns;
  SceneWorkspace scenes(mixed_model());
  Bound bound(columns.state, 0, scenes);
  bound.binding.begin(true);
  bound.binding.select_scene(mixed_model().full_scene());
  bound.load();
  for (std::size_t i = 0; i < bound.step.scene->slots.size(); ++i) {
    const double height = bound.step.data().qpos[bound.step.scene->slots[i].qpos + 2];
    const int prop = bound.workspace.prop[i];
    CHECK((prop == EnvStep::kNoProp ? height >= 100 : height == 0.1));
  }
}

TEST_CASE("A kinematic prop moves evenly to its target and then stands", "[scene_binding]") {
  const test::MixedColumns columns;
  const double target[3] = {-0.15, 0.5, 0.02};
  columns.state.move_kinematic(0, test::kBox, target);
  SceneWorkspace scenes(mixed_model());
  Bound bound(columns.state, 0, scenes);
  bound.begin();
  REQUIRE(bound.step.is_moving(test::kBox));
  CHECK(bound.step.is_asleep(test::kBox));
  bound.binding.move_kinematic_props(2, 5);
  bound.load();
  const int mocap = bound.step.scene->mocap[test::kBox];
  CHECK(bound.step.data().mocap_pos[3 * mocap] == Approx(-0.2 + 0.4 * 0.05));
  REQUIRE(bound.binding.kinematic_bodies().size() == 1);
  CHECK(bound.binding.kinematic_bodies()[0].mocap == mocap);
  CHECK(bound.binding.kinematic_bodies()[0].velocity.x() == Approx(1.0));  // 50 mm in 0.05 s
  bound.binding.move_kinematic_props(5, 5);
  bound.binding.store({}, {});
  CHECK(columns.state.prop_pos_of(0, test::kBox)[0] == Approx(-0.15));
  CHECK(columns.state.prop_qvel_of(0, test::kBox)[0] == 0);
  CHECK(columns.state.status_of(0, test::kBox) == PropStatus::kAsleep);
}

TEST_CASE("Numbers that are not finite or huge are not plausible", "[scene_binding]") {
  const double bad = GENERATE(std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(), -1e11);
  const test::MixedColumns columns;
  SceneWorkspace scenes(mixed_model());
  Bound bound(columns.state, 0, scenes);
  CHECK(bound.binding.state_is_plausible());
  columns.state.prop_quat_of(0, test::kCube1)[2] = bad;  // of a hidden prop
  CHECK_FALSE(bound.binding.state_is_plausible());
  JointArray qvel{};
  qvel[1] = bad;
  bound.begin();
  CHECK(bound.binding.is_plausible({}, {}));
  CHECK_FALSE(bound.binding.is_plausible({}, qvel));
  bound.workspace.motion[test::kCube0].qvel[5] = bad;
  CHECK_FALSE(bound.binding.is_plausible({}, {}));
}

}  // namespace
}  // namespace engram
