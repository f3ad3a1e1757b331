// Constraint rows of single contacts; cone_solver_test compares those of whole episodes with
// MuJoCo's.
#include "core/contact/contact_constraints.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/core/scene/props.h"

namespace engram {
namespace {

constexpr int kCubeBody = 1;  // of the prop in slot 0

// A cube on the table beside a kinematic box, out of the robot's reach.
class Probe {
 public:
  Probe() {
    std::copy(test::kStartPose.begin(), test::kStartPose.end(), data->qpos);
    const double cube[3] = {0, 0.5, 0.02 - 1e-5};
    std::copy_n(cube, 3, data->qpos + scene.slots[0].qpos);
    const double box[3] = {-1, 0.5, 0.02};
    std::copy_n(box, 3, data->mocap_pos);
  }

  void build(std::span<const KinematicBody> kinematic = {}) {
    mj_kinematics(scene.model.get(), data.get());
    mj_collision(scene.model.get(), data.get());
    filter_contacts(*scene.model, *data);
    rows.build(scene, *data, kinematic);
  }

  SceneModel scene = compile_scene(tasks::scene_source(test::mixed_scene()),
                                   std::array{test::kCube0, test::kBox}, RobotDetail::kCollision);
  DataPtr data = make_data(*scene.model);
  ContactConstraints rows{{&scene, 1}};
};

TEST_CASE("A standing cube has four contacts with rows of their own", "[contact_constraints]") {
  Probe probe;
  probe.build();
  REQUIRE(probe.rows.contacts().size() == 4);
  CHECK(probe.rows.contacts_of(kCubeBody) == 4);
  CHECK(probe.rows.contacts_of(kRobotBody) == 0);
  int row = 0;
  for (const ContactConstraints::Contact& contact : probe.rows.contacts()) {
    CHECK(contact.bodies[0] == kCubeBody);
    CHECK(contact.bodies[1] == kNoBody);
    CHECK(contact.cone.row == row);
    CHECK(contact.cone.width[0] == kPropWidth);
    CHECK(contact.cone.width[1] == 0);
    row += contact.cone.dim;
  }
  CHECK(probe.data->nefc == row);
  CHECK(probe.rows.max_rows() == probe.scene.model->njmax);
}

TEST_CASE("Rows have MuJoCo's impedance and reference acceleration", "[contact_constraints]") {
  Probe probe;
  for (int i = 0; i < kPropWidth; ++i) probe.data->qvel[probe.scene.slots[0].dof + i] = 0.1 * i;
  probe.build();
  const int count = probe.data->nefc;
  REQUIRE(count > 0);
  const auto copy = [count](const mjtNum* from) { return std::vector<double>(from, from + count); };
  const std::vector<double> stiffness = copy(probe.data->efc_D);
  const std::vector<double> reference = copy(probe.data->efc_aref);
  const mjModel* model = probe.scene.model.get();
  mj_comPos(model, probe.data.get());
  mj_comVel(model, probe.data.get());
  mj_makeConstraint(model, probe.data.get());
  mj_passive(model, probe.data.get());
  mj_referenceConstraint(model, probe.data.get());
  REQUIRE(probe.data->nefc == count);
  for (std::size_t i = 0; i < stiffness.size(); ++i) {
    CHECK(stiffness[i] == Approx(probe.data->efc_D[i]).epsilon(1e-12));
    CHECK(reference[i] == Approx(probe.data->efc_aref[i]).epsilon(1e-9).margin(1e-9));
  }
}

TEST_CASE("Contacts meet a moving kinematic body at its velocity", "[contact_constraints]") {
  Probe probe;
  probe.data->mocap_pos[0] = -0.04 + 1e-5;  // beside the cube
  const KinematicBody moving{probe.scene.mocap[test::kBox], {0.2, 0, 0}};
  const bool moves = GENERATE(false, true);
  probe.build(moves ? std::span(&moving, 1) : std::span<const KinematicBody>());
  int contacts = 0;
  for (const ContactConstraints::Contact& entry : probe.rows.contacts()) {
    const mjContact& contact = probe.data->contact[entry.index];
    if (std::abs(contact.frame[0]) < 0.9) continue;  // with the table
    ++contacts;
    CHECK(std::abs(probe.data->efc_vel[entry.cone.row]) == Approx(moves ? 0.2 : 0.0).margin(1e-12));
    // A body that approaches is pushed away.
    if (moves) CHECK(probe.data->efc_aref[entry.cone.row] > 0);
  }
  CHECK(contacts > 0);
}

TEST_CASE("Contacts that do not fit into the rows are left out, with MuJoCo's warning",
          "[contact_constraints]") {
  Probe probe;
  probe.scene.model->njmax = 7;
  probe.build();
  CHECK(probe.rows.contacts().size() == 1);
  CHECK(probe.data->nefc <= 7);
  CHECK(probe.data->warning[mjWARN_CNSTRFULL].number == 1);
}

}  // namespace
}  // namespace engram
