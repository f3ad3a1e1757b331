// The broad phase leaves out no contact: MuJoCo's collision detection with its pairs against that
// with all pairs.
#include "core/contact/broad_phase.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <vector>

#include "core/math/random.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

// Props in a heap around the hand, the robot anywhere near its start pose.
void randomize(const SceneModel& scene, RandomStream& random, mjData& data) {
  for (int i = 0; i < kRobotJoints; ++i) {
    data.qpos[i] = test::kStartPose[static_cast<std::size_t>(i)];
    if (i < kArmJoints) data.qpos[i] += random.uniform(-0.3, 0.3);
  }
  const auto randomize_pose = [&](mjtNum* pos, mjtNum* quat) {
    pos[0] = random.uniform(-0.1, 0.1);
    pos[1] = random.uniform(-0.1, 0.1);
    pos[2] = random.uniform(0, 0.2);
    for (int i = 0; i < 4; ++i) quat[i] = random.normal();
    mju_normalize4(quat);
  };
  for (const PropSlot& slot : scene.slots) {
    randomize_pose(data.qpos + slot.qpos, data.qpos + slot.qpos + 3);
  }
  for (int i = 0; i < scene.model->nmocap; ++i) {
    randomize_pose(data.mocap_pos + 3 * i, data.mocap_quat + 4 * i);
  }
  mj_kinematics(scene.model.get(), &data);
}

TEST_CASE("Near pairs give the same contacts in the same order as all pairs", "[broad_phase]") {
  const SceneModel& scene = test::mixed_model().scenes().back();
  BroadPhase broad_phase(*scene.model);
  const DataPtr data = make_data(*scene.model);
  const MujocoScope scope;  // a heap may have more contacts than fit
  RandomStream random(1, 0, 0);
  long contacts = 0;
  long pairs = 0;
  constexpr int kRounds = 2000;
  for (int round = 0; round < kRounds; ++round) {
    randomize(scene, random, *data);
    mj_collision(scene.model.get(), data.get());
    const std::vector<mjContact> all(data->contact, data->contact + data->ncon);
    const mjModel* model = broad_phase.near_pairs(*data);
    mj_collision(model, data.get());
    REQUIRE(data->ncon == static_cast<int>(all.size()));
    for (std::size_t i = 0; i < all.size(); ++i) {
      const mjContact& a = all[i];
      const mjContact& b = data->contact[i];
      REQUIRE(a.geom1 == b.geom1);
      REQUIRE(a.geom2 == b.geom2);
      REQUIRE(a.dim == b.dim);
      REQUIRE(a.dist == b.dist);
      REQUIRE(std::memcmp(a.pos, b.pos, sizeof a.pos) == 0);
      REQUIRE(std::memcmp(a.frame, b.frame, sizeof a.frame) == 0);
      REQUIRE(std::memcmp(a.friction, b.friction, sizeof a.friction) == 0);
      REQUIRE(a.includemargin == b.includemargin);
    }
    contacts += data->ncon;
    pairs += model->npair;
  }
  CHECK(contacts > kRounds);
  CHECK(pairs < kRounds * static_cast<long>(scene.model->npair));
}

TEST_CASE("Distant props leave few pairs", "[broad_phase]") {
  const SceneModel& scene = test::mixed_model().scenes().back();
  BroadPhase broad_phase(*scene.model);
  const DataPtr data = make_data(*scene.model);
  std::copy(test::kStartPose.begin(), test::kStartPose.end(), data->qpos);
  for (std::size_t i = 0; i < scene.slots.size(); ++i) {
    data->qpos[scene.slots[i].qpos + 2] = 100.0 * static_cast<double>(i + 1);
  }
  data->mocap_pos[2] = 1000;
  mj_kinematics(scene.model.get(), data.get());
  // Only pairs of robot bodies are left.
  const mjModel* model = broad_phase.near_pairs(*data);
  CHECK(model->npair < scene.model->npair / 2);
  for (int pair = 0; pair < model->npair; ++pair) {
    for (const int geom : {model->pair_geom1[pair], model->pair_geom2[pair]}) {
      CHECK(scene.slot_of_body[static_cast<std::size_t>(model->geom_bodyid[geom])] == -1);
    }
  }
}

}  // namespace
}  // namespace engram
