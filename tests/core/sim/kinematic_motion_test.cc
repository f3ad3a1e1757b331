// Kinematic props that a task moves.
#include <catch2/catch.hpp>

#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Rig;

// A red cube that moves along x, and two free ones: one ahead of it and one aside.
constexpr double kStart = -0.2;
constexpr double kPace = 0.01;  // m per control step

Rig make_rig(const BatchOptions& options) {
  std::vector<mjcf::Prop> props = {mjcf::cube("red", 0.02, {1, 0, 0, 1}),
                                   mjcf::cube("ahead", 0.02, {0, 1, 0, 1}),
                                   mjcf::cube("aside", 0.02, {0, 0, 1, 1})};
  props[0].body_type = mjcf::BodyType::kKinematic;
  return Rig(std::move(props), {{{kStart, 0.2, 0.02}}, {{-0.1, 0.2, 0.02}}, {{-0.1, -0.2, 0.02}}},
             options);
}

void move_red(Rig& rig, int steps) {
  rig.task().on_before_physics = [&rig](int env) {
    const double pos[3] = {rig.pos(0).x() + kPace, 0.2, 0.02};
    rig.task().engine.state->move_kinematic(env, 0, pos);
  };
  rig.rest(steps);
  rig.task().on_before_physics = [](int) {};
}

TEST_CASE("A moving kinematic prop wakes what is ahead of it and pushes it evenly",
          "[physics][sleep]") {
  BatchOptions options;
  options.sleep = GENERATE(true, false);
  Rig rig = make_rig(options);
  move_red(rig, 2);
  CHECK(rig.pos(0).x() == Approx(kStart + 2 * kPace));
  CHECK(rig.pos(1).x() == Approx(-0.1).margin(1e-6));
  if (options.sleep) CHECK(rig.status(1) == PropStatus::kAsleep);

  move_red(rig, 18);
  CHECK(rig.pos(0).x() == Approx(kStart + 20 * kPace).margin(1e-9));
  // Pushed ahead of the red one, neither run over nor thrown.
  CHECK(rig.pos(1).x() > rig.pos(0).x() + 0.03);
  CHECK(rig.pos(1).x() < rig.pos(0).x() + 0.06);
  CHECK(rig.pos(1).z() == Approx(0.02).margin(0.003));
  CHECK(rig.pos(1).y() == Approx(0.2).margin(0.002));
  CHECK((rig.pos(2) - Eigen::Vector3d(-0.1, -0.2, 0.02)).norm() < 1e-4);
  if (options.sleep) CHECK(rig.status(2) == PropStatus::kAsleep);

  // Once it stops, what it pushed comes to rest and falls asleep.
  rig.rest(30);
  const double stopped = rig.pos(1).x();
  rig.rest(10);
  CHECK(rig.pos(1).x() == Approx(stopped).margin(1e-4));
  if (options.sleep) CHECK(rig.status(1) == PropStatus::kAsleep);
}

TEST_CASE("In MuJoCo a moving kinematic prop pushes and carries at its own speed",
          "[mujoco_physics]") {
  BatchOptions options;
  options.physics = Physics::kMujoco;
  Rig rig = make_rig(options);
  const double on_top[3] = {kStart, 0.2, 0.06};
  const double upright[4] = {1, 0, 0, 0};
  rig.state().place_prop(0, 2, on_top, upright);
  move_red(rig, 10);
  const double way_begins = rig.pos(1).x();
  move_red(rig, 10);
  const double goal = kStart + 20 * kPace;
  CHECK(rig.pos(0).x() == Approx(goal).margin(1e-9));
  CHECK(rig.pos(1).x() == Approx(goal + 0.04).margin(2e-3));
  CHECK(rig.pos(1).x() - way_begins == Approx(10 * kPace).margin(2e-3));
  // With newer versions friction slows it between two touches.
  if (mjVERSION_HEADER < 300) {
    CHECK(rig.state().prop_qvel_of(0, 1)[0] == Approx(20 * kPace).margin(0.04));
  }
  CHECK(rig.pos(1).z() == Approx(0.02).margin(1e-3));
  // At first the lower one slides away beneath it: v^2 / (2 mu g), 6.8 mm.
  CHECK(rig.pos(2).x() == Approx(goal - 0.0068).margin(2e-3));
  CHECK(rig.state().prop_qvel_of(0, 2)[0] == Approx(20 * kPace).margin(0.02));
}

TEST_CASE("A teleported prop does not sweep what lies between", "[physics]") {
  Rig rig = make_rig({});
  rig.rest(2);
  const double pos[3] = {0.1, 0.2, 0.02};
  const double upright[4] = {1, 0, 0, 0};
  rig.state().place_prop(0, 0, pos, upright);
  rig.rest(10);
  CHECK((rig.pos(1) - Eigen::Vector3d(-0.1, 0.2, 0.02)).norm() < 1e-4);
}

TEST_CASE("A kinematic prop that is placed onto a sleeping one does not wake it",
          "[physics][sleep]") {
  Rig rig = make_rig({});
  rig.rest(2);
  const Eigen::Vector3d before = rig.pos(1);
  const double pos[3] = {-0.09, 0.2, 0.02};
  const double upright[4] = {1, 0, 0, 0};
  for (int step = 0; step < 10; ++step) {
    rig.state().place_prop(0, 0, pos, upright);
    rig.rest(1);
  }
  CHECK(rig.status(1) == PropStatus::kAsleep);
  CHECK(rig.pos(1) == before);
}

TEST_CASE("A kinematic prop that moves past nothing does not change a bit of the robot",
          "[physics][sleep]") {
  Rig still = make_rig({});
  Rig moving = make_rig({});
  still.rest(5);
  move_red(moving, 5);
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    CHECK(still.state().qpos.row(0)[joint] == moving.state().qpos.row(0)[joint]);
  }
}

}  // namespace
}  // namespace engram
