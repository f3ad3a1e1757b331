// Balls at speed: they roll as balls do, nothing lets them through, and no contact gives energy.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "mjcf/ball.h"
#include "tests/core/sim/physics_fixture.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Rig;

constexpr double kRadius = 0.02;
constexpr double kGravity = 9.81;

// Every control step is one substep, so that nothing happens unseen in between.
BatchOptions fine_steps(bool sleep = true) {
  BatchOptions options{.sleep = sleep, .substeps = 1};
  return options;
}

mjcf::Prop ball() { return mjcf::ball("ball", kRadius, {1, 0, 0, 1}); }

// The ball is prop 0 of a rig. `velocity`: m/s; `rolling`: it does not slide at first.
void launch(Rig& rig, const Eigen::Vector3d& pos, const Eigen::Vector3d& velocity, bool rolling) {
  const double quat[4] = {1, 0, 0, 0};
  const State& state = *rig.task().engine.state;
  state.place_prop(0, 0, pos.data(), quat, PropStatus::kAwake);
  double* qvel = state.prop_qvel_of(0, 0);
  std::copy_n(velocity.data(), 3, qvel);
  if (!rolling) return;
  const Eigen::Vector3d spin = Eigen::Vector3d::UnitZ().cross(velocity) / kRadius;
  std::copy_n(spin.data(), 3, qvel + 3);
}

Eigen::Vector3d velocity_of(const Rig& rig, int prop) {
  return Eigen::Map<const Eigen::Vector3d>(rig.state().prop_qvel_of(0, prop));
}

// Kinetic and potential energy, J. The props' inertia is that of their axes.
double energy(Rig& rig) {
  double sum = 0;
  for (std::size_t i = 0; i < rig.task().parts.props.size(); ++i) {
    const mjcf::Prop& prop = rig.task().parts.props[i];
    if (prop.body_type != mjcf::BodyType::kDynamic) continue;
    const double* qvel = rig.state().prop_qvel_of(0, static_cast<int>(i));
    for (std::size_t k = 0; k < 3; ++k) {
      sum +=
          0.5 * prop.mass * qvel[k] * qvel[k] + 0.5 * prop.inertia[k] * qvel[3 + k] * qvel[3 + k];
    }
    sum += prop.mass * kGravity * rig.pos(static_cast<int>(i)).z();
  }
  return sum;
}

// --- rolling ---

// Distance after `time` s of a ball that slides at `speed` until it rolls. It may fall from 0.02 m
// first; its landing does not brake it.
double travelled(double speed, bool falls, double time) {
  constexpr double kFriction = 0.3;
  const double fall = falls ? std::sqrt(2 * kRadius / kGravity) : 0;
  if (time <= fall) return speed * time;
  const double rolling = 5.0 / 7 * speed;
  const double braking = (speed - rolling) / (kFriction * kGravity);
  const double rest = time - fall;
  const double sliding = std::min(rest, braking);
  return speed * (fall + sliding) - kFriction * kGravity / 2 * sliding * sliding +
         rolling * (rest - sliding);
}

TEST_CASE("A launched ball slides, then rolls at five sevenths of its speed", "[rolling]") {
  // The published distances are for a ball that is on the table from the start, with the damping,
  // which takes 0.0143 of the rolling speed per second.
  CHECK(travelled(0.25, false, 0.1) == Approx(0.0187).margin(2e-4));
  CHECK(travelled(0.5, false, 0.3) == Approx(0.1105).margin(2e-4));
  CHECK(travelled(1.0, false, 0.05) == Approx(0.0463).margin(2e-4));
  CHECK(travelled(1.0, false, 0.3) == Approx(0.2279).margin(5e-4));
  for (const double speed : {0.25, 0.5, 1.0}) {
    for (const bool falls : {false, true}) {
      Rig rig({ball()}, {{{0.1, -0.8, 0.02}}});
      launch(rig, {0.1, -0.8, falls ? 2 * kRadius : kRadius}, {0, speed, 0}, false);
      for (int step = 1; step <= 30; ++step) {
        rig.rest(1);
        const double expected = travelled(speed, falls, 0.05 * step);
        INFO(speed << " m/s, falls " << falls << ", step " << step);
        CHECK(std::abs(rig.pos(0).y() + 0.8 - expected) <= std::max(0.03 * expected, 0.004));
        if (step < 6) continue;
        CHECK(velocity_of(rig, 0).y() == Approx(5.0 / 7 * speed).epsilon(0.03));
        CHECK(rig.pos(0).z() == Approx(kRadius).margin(0.0005));
      }
      CHECK(std::abs(rig.pos(0).x() - 0.1) < 1e-4);
    }
  }
}

TEST_CASE("A rolling ball keeps its direction and slows by its damping alone", "[rolling]") {
  Rig rig({ball()}, {{{0.1, -0.8, 0.02}}});
  launch(rig, {0.1, -0.8, 0.02}, {0.2, 0.4, 0}, true);
  rig.rest(40);  // 2 s
  const Eigen::Vector3d velocity = velocity_of(rig, 0);
  CHECK(velocity.x() / velocity.y() == Approx(0.5).epsilon(1e-3));
  CHECK(velocity.norm() == Approx(std::sqrt(0.2) * std::exp(-0.0143 * 2)).epsilon(0.005));
  CHECK(rig.status(0) == PropStatus::kAwake);
}

TEST_CASE("A dropped ball does not bounce", "[rolling]") {
  for (const double height : {0.02, 0.1, 0.9}) {
    Rig rig({ball()}, {{{0.2, 0.3, 0.02}}}, fine_steps());
    launch(rig, {0.2, 0.3, kRadius + height}, {0, 0, 0}, false);
    double highest = 0;  // after the first touch
    bool touched = false;
    for (int i = 0; i < 150; ++i) {
      rig.rest(1);
      touched |= rig.pos(0).z() <= kRadius;
      if (touched) highest = std::max(highest, rig.pos(0).z());
    }
    INFO("height " << height);
    REQUIRE(touched);
    CHECK(highest < kRadius + 0.0005 + 0.002 * height);
    CHECK(rig.pos(0).z() == Approx(kRadius).margin(2e-4));
    CHECK(rig.status(0) == PropStatus::kAsleep);
  }
}

TEST_CASE("A ball that rolls off the table falls to the ground beside it", "[rolling]") {
  auto task = std::make_unique<test::SceneTask>(std::vector<mjcf::Prop>{ball()});
  task->parts.table_ends = true;
  test::SceneTask* scene = task.get();
  Batch batch(std::move(task), BatchOptions{});
  scene->on_reset = [&](int index) {
    const double pos[3] = {-0.1, 1.0, kRadius};
    const double quat[4] = {1, 0, 0, 0};
    scene->engine.state->place_prop(index, 0, pos, quat, PropStatus::kAwake);
    scene->engine.state->prop_qvel_of(index, 0)[1] = 0.9;
  };
  batch.reset();
  const double* pos = batch.state().prop_pos_of(0, 0);
  for (int i = 0; i < 6; ++i) batch.step(test::zeros(batch));
  CHECK(pos[1] == Approx(1.2).margin(0.02));
  CHECK(pos[2] == Approx(kRadius).margin(0.0005));
  for (int i = 0; i < 30; ++i) batch.step(test::zeros(batch));
  CHECK(pos[1] > 1.3);
  CHECK(pos[2] == Approx(kRadius - 0.91964).margin(0.001));
}

// --- obstacles ---

constexpr double kSpeeds[] = {0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0};

// Penetration of the ball into an obstacle: the displacement of one substep, before the contact,
// and the compliance of the contact.
constexpr double kOneStep = 0.01;       // s
constexpr double kCompliance = 0.0008;  // m

// Contacts stop a ball where it touches.
constexpr double kContactGap = 1e-5;  // m

// Energy after a contact, as a share of the energy before it. A contact adds no energy, but it
// pushes the ball out of the obstacle that the last substep carried it into: with at most 15 % of
// the speed.
constexpr double kPushedOut = 0.0225;

// Table contacts lift a ball that is put on it to the height at which it rests, 14 um higher.
constexpr double kLift = 2e-5;  // m

class Losses {
 public:
  explicit Losses(Rig& rig)
      : first_(energy(rig) + rig.task().parts.props[0].mass * kGravity * kLift), min_(first_) {}
  void note(double energy) {
    gain_ = std::max(gain_, (energy - min_) / first_);
    min_ = std::min(min_, energy);
    max_ = std::max(max_, energy / first_);
  }
  double gain() const { return gain_; }
  double most() const { return max_; }  // share of the first energy

 private:
  double first_, min_;
  double gain_ = 0;
  double max_ = 0;
};

TEST_CASE("No ball passes through a finger", "[rolling]") {
  for (const double gripper : {tasks::kGripperClosed, tasks::kGripperOpen}) {
    for (const double speed : kSpeeds) {
      for (const double offset : {-0.006, 0.0, 0.006}) {
        for (const bool rolling : {false, true}) {
          Rig rig({ball()}, {{{0.3, 0.6, 0.02}}}, fine_steps());
          rig.move({-0.1, 0, 0.02}, 200, gripper);
          const double* fingers = rig.state().qpos.row(0) + kArmJoints;
          const double face = rig.tcp().y() - std::max(fingers[0], fingers[1]) - 0.0152;
          launch(rig, {-0.1 + offset, face - 0.1, kRadius}, {0, speed, 0}, rolling);
          Losses losses(rig);
          double deepest = 0;
          for (int i = 0; i < 100; ++i) {
            rig.rest(1, gripper);
            losses.note(energy(rig));
            deepest = std::max(deepest, rig.pos(0).y() + kRadius - face);
          }
          INFO("gripper " << gripper << ", " << speed << " m/s, offset " << offset << ", rolling "
                          << rolling << ", deepest " << 1000 * deepest << " mm, gain "
                          << losses.gain() << ", most " << losses.most());
          CHECK(deepest < kOneStep * speed + kCompliance);
          CHECK(rig.pos(0).y() < face);
          CHECK(losses.gain() < kPushedOut);
          CHECK(losses.most() < 1 + 1e-6);
        }
      }
    }
  }
}

mjcf::Prop wall(const char* name, mjcf::GeomType type, mjcf::Vec3 size, double mass) {
  mjcf::Prop prop;
  prop.name = name;
  prop.geoms.push_back({.type = type, .size = size});
  prop.mass = mass;
  prop.inertia = {mass * 1e-3, mass * 1e-3, mass * 1e-3, 0, 0, 0};
  prop.body_type = mass > 0 ? mjcf::BodyType::kDynamic : mjcf::BodyType::kKinematic;
  return prop;
}

// Penetration depth of the ball in a prop that is a box or an upright cylinder, m.
double overlap(Rig& rig, int prop) {
  const mjcf::Geom& shape = rig.task().parts.props[static_cast<std::size_t>(prop)].geoms[0];
  const Eigen::Vector3d gap = rig.pos(0) - rig.pos(prop);
  if (shape.type == mjcf::GeomType::kCylinder) {
    return shape.size[0] + kRadius - gap.head<2>().norm();
  }
  const double* q = rig.state().prop_quat_of(0, prop);
  const Eigen::Vector3d local = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).conjugate() * gap;
  const Eigen::Vector3d half(shape.size[0], shape.size[1], shape.size[2]);
  return kRadius - (local - local.cwiseMin(half).cwiseMax(-half)).norm();
}

TEST_CASE("No ball passes through a cube, a mug or a thin wall", "[rolling]") {
  struct Target {
    mjcf::Prop prop;
    double height;  // of its centre
    double half_depth;
  };
  const Target targets[] = {
      {mjcf::cube("target", 0.02, {0, 1, 0, 1}), 0.02, 0.02},
      {wall("target", mjcf::GeomType::kCylinder, {0.04, 0.06, 0}, 0.3), 0.06, 0.04},
      {wall("target", mjcf::GeomType::kBox, {0.05, 0.003, 0.04}, 0), 0.04, 0.003},
      {wall("target", mjcf::GeomType::kCylinder, {0.04, 0.06, 0}, 0), 0.06, 0.04},
  };
  for (const Target& target : targets) {
    for (const double speed : kSpeeds) {
      for (const double offset : {-0.008, 0.0, 0.008}) {
        Rig rig({ball(), target.prop}, {{{0.3, 0.6, 0.02}}, {{0.1, 0.0, target.height}}},
                fine_steps());
        launch(rig, {0.1 + offset, -target.half_depth - 0.12, kRadius}, {0, speed, 0}, true);
        Losses losses(rig);
        double deepest = -1;
        for (int i = 0; i < 200; ++i) {
          rig.rest(1);
          losses.note(energy(rig));
          deepest = std::max(deepest, overlap(rig, 1));
        }
        INFO("target of depth " << target.half_depth << ", mass " << target.prop.mass << ", "
                                << speed << " m/s, offset " << offset << ", deepest "
                                << 1000 * deepest << " mm, gain " << losses.gain());
        CHECK(deepest > -kOneStep * speed - kContactGap);  // it did hit
        CHECK(deepest < kOneStep * speed + kCompliance);
        CHECK(losses.gain() < kPushedOut);
        // Cubes give way, and a ball may roll past a cylinder.
        const bool is_wall = target.prop.body_type == mjcf::BodyType::kKinematic &&
                             target.prop.geoms[0].type == mjcf::GeomType::kBox;
        if (is_wall || offset == 0) CHECK(rig.pos(0).y() < rig.pos(1).y());
      }
    }
  }
}

// --- sleep ---

TEST_CASE("A fast ball wakes what sleeps in its way in time", "[rolling][sleep]") {
  for (const double speed : {0.3, 0.7, 1.0, 2.0}) {
    std::vector<Eigen::Vector3d> ends;
    for (const bool sleep : {true, false}) {
      Rig rig({ball(), mjcf::cube("cube", 0.02, {0, 1, 0, 1})},
              {{{0.3, 0.6, 0.02}}, {{0.1, 0.0, 0.02}}}, fine_steps(sleep));
      rig.rest(30);  // the cube settles where it is awake
      launch(rig, {0.1, -0.2, kRadius}, {0, speed, 0}, true);
      double deepest = 0;
      for (int i = 0; i < 120; ++i) {
        rig.rest(1);
        deepest = std::max(deepest, 2 * kRadius - (rig.pos(1) - rig.pos(0)).y());
      }
      INFO(speed << " m/s, sleep " << sleep);
      CHECK(rig.pos(1).y() > 0.001);
      CHECK(deepest < kOneStep * speed + kCompliance);
      ends.push_back(rig.pos(0));
      ends.push_back(rig.pos(1));
    }
    INFO(speed << " m/s");
    CHECK((ends[0] - ends[2]).norm() < 0.002);
    CHECK((ends[1] - ends[3]).norm() < 0.002);
  }
}

}  // namespace
}  // namespace engram
