// Reference accelerations of sliding balls. rolling_test has the motion that they give.
#include "core/contact/coulomb_sliding.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/core/scene/props.h"

namespace engram {
namespace {

constexpr double kGravity = 9.81;
constexpr double kFriction = 0.3;

// One free prop that moves along x on the table, out of the robot's reach.
class Probe {
 public:
  Probe(int prop, double height, double speed)
      : scene(compile_scene(tasks::scene_source(test::mixed_scene()), std::array{prop},
                            RobotDetail::kCollision)) {
    std::copy(test::kStartPose.begin(), test::kStartPose.end(), data->qpos);
    const PropSlot& slot = scene.slots[0];
    const double pos[3] = {0, 0.5, height - 1e-5};
    std::copy_n(pos, 3, data->qpos + slot.qpos);
    data->qvel[slot.dof] = speed;
    data->qacc_smooth[slot.dof + 2] = -kGravity;
    mj_kinematics(scene.model.get(), data.get());
    mj_collision(scene.model.get(), data.get());
    filter_contacts(*scene.model, *data);
    rows.build(scene, *data, {});
    before.assign(data->efc_aref, data->efc_aref + data->nefc);
    apply_coulomb_sliding(scene, *data, rows);
  }
  bool changed() const { return !std::equal(before.begin(), before.end(), data->efc_aref); }

  SceneModel scene;
  DataPtr data = make_data(*scene.model);
  ContactConstraints rows{{&scene, 1}};
  std::vector<double> before;
};

TEST_CASE("A sliding ball is braked by mu times its weight", "[coulomb_sliding]") {
  const Probe probe(test::kBall, 0.03, 1.0);
  REQUIRE(probe.rows.contacts().size() == 1);
  CHECK(probe.changed());
  const int row = probe.rows.contacts()[0].cone.row;
  const double* velocity = probe.data->efc_vel + row;
  const double* reference = probe.data->efc_aref + row;
  CHECK(reference[0] == probe.before[0]);
  const double along = (velocity[1] * reference[1] + velocity[2] * reference[2]) /
                       std::hypot(velocity[1], velocity[2]);
  // The contact point of a solid ball accelerates by 7/2 of the friction's share of the weight.
  CHECK(along == Approx(-3.5 * kFriction * kGravity).epsilon(0.1));
}

TEST_CASE("A ball that friction stops within the substep keeps MuJoCo's friction",
          "[coulomb_sliding]") {
  CHECK_FALSE(Probe(test::kBall, 0.03, 0.0).changed());
  CHECK_FALSE(Probe(test::kBall, 0.03, 1e-3).changed());
}

TEST_CASE("A sliding cube with several contacts keeps MuJoCo's friction", "[coulomb_sliding]") {
  const Probe probe(test::kCube0, 0.02, 1.0);
  CHECK(probe.rows.contacts().size() == 4);
  CHECK_FALSE(probe.changed());
}

}  // namespace
}  // namespace engram
