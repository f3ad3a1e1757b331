// Free bodies against MuJoCo's velocities, inertia and accelerations.
#include "core/scene/free_body.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/frame.h"
#include "core/math/random.h"
#include "core/scene/mujoco_handle.h"

namespace engram {
namespace {

constexpr double kGravity = 9.81;
constexpr double kDamping = 0.05;  // 1/s

// A body whose centre of mass and principal axes are not those of its frame.
class Fixture {
 public:
  Fixture()
      : model_(compile_model(
            "<mujoco><option gravity='0 0 -9.81'/><worldbody><body name='box'><freejoint/>"
            "<inertial pos='0.01 -0.02 0.03' quat='0.9 0.3 -0.2 0.1' mass='0.2' "
            "diaginertia='0.0003 0.0004 0.0006'/></body></worldbody></mujoco>")),
        data_(make_data(*model_)),
        body_(*model_, 1) {}

  void randomize(RandomStream& random) {
    for (int i = 0; i < 3; ++i) data_->qpos[i] = random.uniform(-1, 1);
    for (int i = 3; i < 7; ++i) data_->qpos[i] = random.normal();
    mju_normalize4(data_->qpos + 3);
    for (int i = 0; i < 6; ++i) data_->qvel[i] = random.uniform(-3, 3);
    mj_forward(model_.get(), data_.get());
  }
  FreeBodyState load() const { return body_.load(data_->qpos, data_->qpos + 3, data_->qvel); }
  const FreeBody& body() const { return body_; }
  const mjModel& model() const { return *model_; }
  const mjData& data() const { return *data_; }

 private:
  ModelPtr model_;
  DataPtr data_;
  FreeBody body_;
};

Vec3 momentum_of(const FreeBody& body, const FreeBodyState& state) {
  return body.inv_inertia(state.quat).inverse() * state.angular;
}

TEST_CASE("A free body's motion is that of its centre of mass, and comes back", "[free_body]") {
  Fixture fixture;
  RandomStream random(1, 0, 0);
  for (int round = 0; round < 100; ++round) {
    fixture.randomize(random);
    const mjData& data = fixture.data();
    const FreeBodyState state = fixture.load();
    mjtNum velocity[6];  // angular, linear
    mj_objectVelocity(&fixture.model(), &data, mjOBJ_BODY, 1, velocity, 0);
    REQUIRE(state.center.isApprox(Eigen::Map<const Vec3>(data.xipos + 3), 1e-12));
    REQUIRE(state.angular.isApprox(Eigen::Map<const Vec3>(velocity), 1e-12));
    REQUIRE(state.linear.isApprox(Eigen::Map<const Vec3>(velocity + 3), 1e-12));

    std::array<double, 13> stored;
    fixture.body().store(state, stored.data(), stored.data() + 3, stored.data() + 7);
    for (std::size_t i = 0; i < 7; ++i) REQUIRE(std::abs(stored[i] - data.qpos[i]) < 1e-14);
    for (std::size_t i = 0; i < 6; ++i) REQUIRE(std::abs(stored[7 + i] - data.qvel[i]) < 1e-14);
  }
}

TEST_CASE("A free body's inertia is MuJoCo's", "[free_body]") {
  Fixture fixture;
  RandomStream random(2, 0, 0);
  fixture.randomize(random);
  const Eigen::Map<const RowMat3> axes(fixture.data().ximat + 9);
  const Vec3 inertia(0.0003, 0.0004, 0.0006);
  const Mat3 expected = axes * inertia.cwiseInverse().asDiagonal() * axes.transpose();
  CHECK(fixture.body().inv_inertia(fixture.load().quat).isApprox(expected, 1e-12));
  CHECK(fixture.body().inv_mass() == Approx(5));
}

TEST_CASE("A free body falls, and turns as MuJoCo's does", "[free_body]") {
  constexpr double kTimestep = 1e-6;  // s; the step is explicit
  Fixture fixture;
  RandomStream random(3, 0, 0);
  for (int round = 0; round < 50; ++round) {
    fixture.randomize(random);
    const FreeBodyState before = fixture.load();
    FreeBodyState after = before;
    fixture.body().accelerate(after, kGravity, kTimestep);
    REQUIRE((after.linear - before.linear - kTimestep * Vec3(0, 0, -kGravity)).norm() < 1e-12);
    REQUIRE(after.center == before.center);

    // Angular, in body axes; the axes turn about the velocity itself.
    const Vec3 theirs = before.quat * Eigen::Map<const Vec3>(fixture.data().qacc + 3);
    const Vec3 mine = (after.angular - before.angular) / kTimestep + kDamping * before.angular;
    REQUIRE((mine - theirs).norm() < 1e-3);
    REQUIRE(theirs.norm() > 0.01);
  }
}

TEST_CASE("The gyroscopic torque keeps the size of the angular momentum", "[free_body]") {
  constexpr double kTimestep = 0.01;
  Fixture fixture;
  RandomStream random(4, 0, 0);
  for (int round = 0; round < 50; ++round) {
    fixture.randomize(random);
    FreeBodyState state = fixture.load();
    state.angular *= 20;
    const double before = momentum_of(fixture.body(), state).norm();
    fixture.body().accelerate(state, kGravity, kTimestep);
    const double after = momentum_of(fixture.body(), state).norm();
    REQUIRE(after == Approx((1 - kDamping * kTimestep) * before));
  }
}

TEST_CASE("A body at rest begins to fall and does not turn", "[free_body]") {
  const Fixture fixture;
  FreeBodyState state;
  fixture.body().accelerate(state, kGravity, 0.01);
  CHECK(state.linear == Vec3(0, 0, -0.01 * kGravity));
  CHECK(state.angular == Vec3::Zero());
}

TEST_CASE("A spin beyond 100 rad/s is slowed to it, along its axis", "[free_body]") {
  FreeBodyState state;
  state.angular = {0, 60, 80};
  limit_spin(state);
  CHECK(state.angular == Vec3(0, 60, 80));
  state.angular = {90, 0, -1200};
  const Vec3 direction = state.angular.normalized();
  limit_spin(state);
  CHECK(state.angular.norm() == Approx(100));
  CHECK(state.angular.normalized().isApprox(direction));
}

}  // namespace
}  // namespace engram
