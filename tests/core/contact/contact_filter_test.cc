#include "core/contact/contact_filter.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/random.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

using Vec3 = Eigen::Vector3d;

// The whole mixed scene with all props far away, the robot at its start pose.
class Probe {
 public:
  Probe() {
    std::copy(test::kStartPose.begin(), test::kStartPose.end(), data->qpos);
    for (std::size_t i = 0; i < scene.slots.size(); ++i) {
      data->qpos[scene.slots[i].qpos + 2] = 100.0 * static_cast<double>(i + 1);
    }
    data->mocap_pos[2] = 1000;
  }

  // Slots 0 and 1 hold cubes, 2 the ball.
  mjtNum* qpos(int slot) const { return data->qpos + at(slot).qpos; }
  mjtNum* qvel(int slot) const { return data->qvel + at(slot).dof; }
  int body(int slot) const { return at(slot).body; }
  void place(int slot, const Vec3& pos) const { std::copy_n(pos.data(), 3, qpos(slot)); }

  void find_contacts() const {
    mj_kinematics(&model, data.get());
    mj_collision(&model, data.get());
  }
  void filter() const {
    find_contacts();
    filter_contacts(model, *data);
  }
  bool touches(const mjContact& contact, int body) const {
    return model.geom_bodyid[contact.geom1] == body || model.geom_bodyid[contact.geom2] == body;
  }

  const SceneModel& scene = test::mixed_model().scenes().back();
  const mjModel& model = *scene.model;
  DataPtr data = make_data(model);

 private:
  const PropSlot& at(int slot) const { return scene.slots[static_cast<std::size_t>(slot)]; }
};

constexpr double kFar = 0.5;  // m, y of the table where the hand is not

TEST_CASE("Only a fast approach makes a contact speculative", "[contact_filter]") {
  Probe probe;
  probe.place(0, {0, kFar, 0.02 + 0.008});  // 8 mm above the table
  const double speed = GENERATE(0.0, -0.3, -1.0);
  probe.qvel(0)[2] = speed;
  probe.filter();
  int contacts = 0;
  for (int i = 0; i < probe.data->ncon; ++i) {
    const mjContact& contact = probe.data->contact[i];
    if (!probe.touches(contact, probe.body(0))) continue;
    ++contacts;
    CHECK(contact.dist > 0);
    // The timestep is 0.01 s; the margin for acceleration 2 mm.
    const bool may_touch = -speed * 0.01 + 0.002 > 0.008;
    CHECK((contact.exclude == 0) == may_touch);
    if (!may_touch) continue;
    CHECK(contact.dim == 1);  // without friction
    CHECK(contact.includemargin < contact.dist);
  }
  CHECK(contacts >= 4);
}

TEST_CASE("Contacts of a resting prop are left as MuJoCo finds them", "[contact_filter]") {
  Probe probe;
  probe.place(0, {0, kFar, 0.02 - 1e-5});
  probe.find_contacts();
  const std::vector<mjContact> before(probe.data->contact, probe.data->contact + probe.data->ncon);
  filter_contacts(probe.model, *probe.data);
  REQUIRE(before.size() >= 4);
  for (std::size_t i = 0; i < before.size(); ++i) {
    CHECK(probe.data->contact[i].exclude == before[i].exclude);
    CHECK(probe.data->contact[i].dim == before[i].dim);
    CHECK(probe.data->contact[i].includemargin == before[i].includemargin);
  }
}

TEST_CASE("A prop around the fingers is pushed in one horizontal direction", "[contact_filter]") {
  Probe probe;
  probe.data->qpos[kArmJoints] = probe.data->qpos[kArmJoints + 1] = 0;  // closed
  mj_kinematics(&probe.model, probe.data.get());
  const int finger = mj_name2id(&probe.model, mjOBJ_BODY, "leftfinger");
  const int tip = probe.model.body_geomadr[finger] + probe.model.body_geomnum[finger] - 1;
  const Vec3 middle = Eigen::Map<const Vec3>(probe.data->geom_xpos + 3 * tip);
  probe.place(0, middle + Vec3(0.006, 0, 0));
  probe.filter();
  int contacts = 0;
  Vec3 direction = Vec3::Zero();
  for (int i = 0; i < probe.data->ncon; ++i) {
    const mjContact& contact = probe.data->contact[i];
    if (!probe.touches(contact, probe.body(0)) || contact.exclude != 0) continue;
    const bool from_robot = probe.model.geom_bodyid[contact.geom2] == probe.body(0);
    const Vec3 normal = (from_robot ? 1 : -1) * Eigen::Map<const Vec3>(contact.frame);
    if (contacts++ == 0) direction = normal;
    CHECK(contact.dim == 1);
    CHECK(normal == direction);
    CHECK(contact.includemargin > contact.dist);
  }
  CHECK(contacts > 0);
  CHECK(direction.z() == 0);
  CHECK(direction.x() > 0.5);  // away from the tips
}

TEST_CASE("No contact of boxes that acts is deeper than they overlap", "[contact_filter]") {
  Probe probe;
  const MujocoScope scope;
  RandomStream random(3, 0, 0);
  int acting = 0;
  for (int round = 0; round < 3000; ++round) {
    for (const int slot : {0, 1}) {
      mjtNum* qpos = probe.qpos(slot);
      for (int i = 0; i < 3; ++i) qpos[i] = random.uniform(-0.015, 0.015);
      qpos[1] += kFar;
      qpos[2] += 0.3;
      for (int i = 3; i < 7; ++i) qpos[i] = random.normal();
      mju_normalize4(qpos + 3);
    }
    probe.filter();
    for (int i = 0; i < probe.data->ncon; ++i) {
      const mjContact& contact = probe.data->contact[i];
      if (contact.exclude != 0 || !probe.touches(contact, probe.body(0)) ||
          !probe.touches(contact, probe.body(1))) {
        continue;
      }
      ++acting;
      const Eigen::Map<const Vec3> normal(contact.frame);
      double apart = 0;
      for (const int geom : {contact.geom1, contact.geom2}) {
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> axes(
            probe.data->geom_xmat + 9 * geom);
        apart += (geom == contact.geom2 ? 1 : -1) *
                     normal.dot(Eigen::Map<const Vec3>(probe.data->geom_xpos + 3 * geom)) -
                 Eigen::Map<const Vec3>(probe.model.geom_size + 3 * geom)
                     .dot((axes.transpose() * normal).cwiseAbs());
      }
      REQUIRE((contact.dist > -0.001 || contact.dist >= apart - 0.001 - 1e-12));
    }
  }
  CHECK(acting > 3000);
}

}  // namespace
}  // namespace engram
