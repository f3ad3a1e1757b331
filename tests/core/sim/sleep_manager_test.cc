// SleepManager: sleep has no effect on results. Runs the same scenes with and without it.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "tests/core/sim/physics_fixture.h"

namespace engram {
namespace {

using test::Placement, test::Rig;

BatchOptions with_sleep(bool sleep) {
  BatchOptions options{.sleep = sleep};
  return options;
}

// Final positions of all cubes after a script, with and without sleep.
struct Outcome {
  std::vector<Eigen::Vector3d> pos;
  int awake = 0;
  int max_awake = 0;
};

using Script = std::function<void(Rig&)>;

Outcome play(const std::vector<Placement>& cubes, bool sleep, const Script& script) {
  Rig rig = Rig::cubes(cubes, with_sleep(sleep));
  Outcome outcome;
  rig.task().on_advance = [&](int) {
    int awake = 0;
    for (int i = 0; i < static_cast<int>(cubes.size()); ++i) {
      awake += rig.status(i) == PropStatus::kAwake ? 1 : 0;
    }
    outcome.max_awake = std::max(outcome.max_awake, awake);
  };
  script(rig);
  for (int i = 0; i < static_cast<int>(cubes.size()); ++i) {
    outcome.pos.push_back(rig.pos(i));
    outcome.awake += rig.status(i) == PropStatus::kAwake ? 1 : 0;
  }
  return outcome;
}

double largest_difference(const Outcome& a, const Outcome& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.pos.size(); ++i) {
    worst = std::max(worst, (a.pos[i] - b.pos[i]).norm());
  }
  return worst;
}

const Eigen::Vector3d kAside(-0.1, 0.3, 0.4);

TEST_CASE("A cube that rests stays exactly where it was put", "[sleep]") {
  Rig rig = Rig::cubes({{{0.05, -0.1, 0.02}}});
  rig.rest(50);
  CHECK(rig.status(0) == PropStatus::kAsleep);
  CHECK(rig.pos(0) == Eigen::Vector3d(0.05, -0.1, 0.02));
}

TEST_CASE("Without sleep a resting cube settles by less than half a millimetre", "[sleep]") {
  Rig rig = Rig::cubes({{{0.05, -0.1, 0.02}}}, with_sleep(false));
  rig.rest(100);
  CHECK(rig.status(0) == PropStatus::kAwake);
  CHECK((rig.pos(0) - Eigen::Vector3d(0.05, -0.1, 0.02)).norm() < 5e-4);
}

TEST_CASE("A dropped cube lands, falls asleep and lies where it would without sleep", "[sleep]") {
  for (const double height : {0.03, 0.05, 0.1}) {
    const std::vector<Placement> cubes = {{{0.05, -0.1, 0.02 + height}, PropStatus::kAwake}};
    const Script wait = [](Rig& rig) { rig.rest(60); };
    const Outcome on = play(cubes, true, wait);
    const Outcome off = play(cubes, false, wait);
    INFO("height " << height);
    CHECK(on.awake == 0);
    CHECK(off.awake == 1);
    CHECK(on.max_awake == 1);
    CHECK(on.pos[0].z() == Approx(0.02).margin(5e-4));
    CHECK(largest_difference(on, off) < 5e-4);
  }
}

TEST_CASE("A cube that falls onto a sleeping one wakes it", "[sleep]") {
  const std::vector<Placement> cubes = {{{0.05, -0.1, 0.02}},
                                        {{0.06, -0.1, 0.12}, PropStatus::kAwake}};
  const Script wait = [](Rig& rig) { rig.rest(80); };
  const Outcome on = play(cubes, true, wait);
  const Outcome off = play(cubes, false, wait);
  CHECK(on.max_awake == 2);
  CHECK(on.awake == 0);
  CHECK(on.pos[1].z() == Approx(0.06).margin(1e-3));  // one upon the other
  CHECK(largest_difference(on, off) < 1e-3);
}

TEST_CASE("A cube pushed into a sleeping one moves it as without sleep", "[sleep]") {
  const std::vector<Placement> cubes = {{{0.0, 0.0, 0.02}}, {{0.08, 0.0, 0.02}}};
  // The closed gripper beside the first cube, then steadily along x.
  const Script push = [](Rig& rig) {
    rig.move({-0.08, 0, 0.08}, 30, -0.6);
    rig.move({-0.08, 0, 0.025}, 20, -0.6);
    for (int i = 0; i < 30; ++i) rig.move({-0.08 + 0.005 * (i + 1), 0, 0.025}, 1, -0.6, 0.3F);
    rig.rest(30, -0.6);
  };
  const Outcome on = play(cubes, true, push);
  const Outcome off = play(cubes, false, push);
  CHECK(on.max_awake == 2);
  CHECK(on.pos[1].x() > 0.1);
  CHECK(largest_difference(on, off) < 1e-3);
}

TEST_CASE("A chain of sleeping cubes wakes one after another", "[sleep]") {
  std::vector<Placement> cubes;
  for (int i = 0; i < 4; ++i) cubes.push_back({{0.0 + 0.08 * i, 0.0, 0.02}});
  Rig rig = Rig::cubes(cubes);
  rig.move({-0.08, 0, 0.08}, 30, -0.6);
  rig.move({-0.08, 0, 0.025}, 20, -0.6);
  std::vector<int> woke(4, -1);
  for (int step = 0; step < 45; ++step) {
    rig.move({-0.08 + 0.005 * (step + 1), 0, 0.025}, 1, -0.6, 0.3F);
    for (int i = 0; i < 4; ++i) {
      if (woke[static_cast<std::size_t>(i)] < 0 && rig.status(i) == PropStatus::kAwake) {
        woke[static_cast<std::size_t>(i)] = step;
      }
    }
  }
  CHECK(woke[0] >= 0);
  CHECK(woke[0] < woke[1]);
  CHECK(woke[1] < woke[2]);
  CHECK(woke[2] < woke[3]);
  // None passes through another.
  for (int i = 0; i < 3; ++i) CHECK(rig.pos(i + 1).x() - rig.pos(i).x() > 0.039);
  rig.move(kAside, 30, -0.6);
  for (int i = 0; i < 4; ++i) CHECK(rig.status(i) == PropStatus::kAsleep);
}

TEST_CASE("A cube beside the hand stays awake until the hand has gone", "[sleep]") {
  Rig rig = Rig::cubes({{{0.0, 0.0, 0.02}}});
  rig.move({0, 0, 0.05}, 30, -0.6);
  CHECK(rig.status(0) == PropStatus::kAwake);
  rig.rest(20, -0.6);
  CHECK(rig.status(0) == PropStatus::kAwake);
  rig.move(kAside, 30, -0.6);
  CHECK(rig.status(0) == PropStatus::kAsleep);
}

TEST_CASE("A hidden cube neither moves nor collides", "[sleep]") {
  const bool sleep = GENERATE(true, false);
  Rig rig =
      Rig::cubes({{{0.0, 0.0, 0.02}}, {{0.0, 0.0, 0.1}, PropStatus::kAwake}}, with_sleep(sleep));
  const double reported[3] = {0.3, 0.4, 1000};
  rig.task().engine.state->hide_prop(0, 0, reported);
  rig.rest(40);
  // The other cube falls through where it was, and so does the gripper.
  CHECK(rig.pos(1).z() == Approx(0.02).margin(1e-3));
  CHECK(rig.pos(0) == Eigen::Vector3d(0.3, 0.4, 1000));
  CHECK(rig.status(0) == PropStatus::kHidden);

  Rig pressed = Rig::cubes({{{0.0, 0.0, 0.02}}}, with_sleep(sleep));
  pressed.task().engine.state->hide_prop(0, 0, reported);
  pressed.move({0, 0, 0.015}, 40, -0.6);
  CHECK(pressed.tcp().z() == Approx(0.015).margin(2e-3));
  CHECK(pressed.state().finger_force.row(0)[2] == 0);
}

TEST_CASE("A cube under the closed gripper stops it", "[sleep]") {
  Rig rig = Rig::cubes({{{0.0, 0.0, 0.02}}}, with_sleep(GENERATE(true, false)));
  rig.move({0, 0, 0.015}, 40, -0.6);
  // The tips end 9.5 mm below the TCP; the cube is 40 mm high.
  CHECK(rig.tcp().z() > 0.045);
}

mjcf::Prop block(double half_height) {
  mjcf::Prop prop;
  prop.name = "block";
  prop.body_type = mjcf::BodyType::kKinematic;
  prop.geoms.push_back({.type = mjcf::GeomType::kBox, .size = {0.05, 0.05, half_height}});
  return prop;
}

TEST_CASE("A kinematic prop is solid although nothing is awake", "[sleep]") {
  const bool sleep = GENERATE(true, false);
  Rig rig({block(0.05)}, {{{0.0, 0.0, 0.05}}}, with_sleep(sleep));
  double lowest = 1;
  for (int i = 0; i < 60; ++i) {
    rig.move({0, 0, 0.09}, 1, -0.6, 0.3F);
    lowest = std::min(lowest, rig.tcp().z());
  }
  CHECK(lowest > 0.1 + 0.0095 - 0.004);  // a soft contact gives a little
  CHECK(lowest < 0.115);
  CHECK(rig.status(0) == PropStatus::kAsleep);
  CHECK(rig.pos(0) == Eigen::Vector3d(0, 0, 0.05));

  // Moved away by its task it is no longer in the way.
  const double pos[3] = {0.3, 0.3, 0.05};
  const double quat[4] = {1, 0, 0, 0};
  rig.task().engine.state->place_prop(0, 0, pos, quat);
  rig.move({0, 0, 0.05}, 30, -0.6);
  CHECK(rig.tcp().z() == Approx(0.05).margin(3e-3));
}

TEST_CASE("A cube dropped onto a kinematic prop rests on it", "[sleep]") {
  const bool sleep = GENERATE(true, false);
  Rig rig({block(0.03), mjcf::cube("cube", 0.02, {1, 0, 0, 1})},
          {{{0.1, 0.1, 0.03}}, {{0.1, 0.1, 0.1}, PropStatus::kAwake}}, with_sleep(sleep));
  rig.rest(60);
  CHECK(rig.pos(1).z() == Approx(0.08).margin(1e-3));
  CHECK((rig.status(1) == PropStatus::kAsleep) == sleep);
}

TEST_CASE("A hidden kinematic prop lets everything through", "[sleep]") {
  Rig rig({block(0.05)}, {{{0.0, 0.0, 0.05}}}, with_sleep(GENERATE(true, false)));
  const double pos[3] = {0, 0, 0.05};
  rig.task().engine.state->hide_prop(0, 0, pos);
  rig.move({0, 0, 0.06}, 40, -0.6);
  CHECK(rig.tcp().z() == Approx(0.06).margin(3e-3));
}

}  // namespace
}  // namespace engram
