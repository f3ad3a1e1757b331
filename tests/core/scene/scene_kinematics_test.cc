// Poses of bodies and geoms against mj_kinematics.
#include "core/scene/scene_kinematics.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/math/random.h"
#include "tests/core/scene/props.h"

namespace engram {
namespace {

void randomize(const PhysicsModel& physics, const SceneModel& scene, RandomStream& random,
               mjData& data) {
  const mjModel& model = *scene.model;
  for (int i = 0; i < kRobotJoints; ++i) {
    data.qpos[i] = random.uniform(physics.joint_ranges()[2 * i], physics.joint_ranges()[2 * i + 1]);
  }
  const auto randomize_pose = [&](mjtNum* pos, mjtNum* quat) {
    for (int i = 0; i < 3; ++i) pos[i] = random.uniform(-1, 1);
    for (int i = 0; i < 4; ++i) quat[i] = random.normal();
    mju_normalize4(quat);
  };
  for (const PropSlot& slot : scene.slots) {
    randomize_pose(data.qpos + slot.qpos, data.qpos + slot.qpos + 3);
  }
  for (int i = 0; i < model.nmocap; ++i) {
    randomize_pose(data.mocap_pos + 3 * i, data.mocap_quat + 4 * i);
  }
}

double difference(const mjtNum* a, const mjtNum* b, int count) {
  double most = 0;
  for (int i = 0; i < count; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

TEST_CASE("All bodies and geoms are posed as by mj_kinematics", "[scene_kinematics]") {
  const PhysicsModel& physics = test::mixed_model();
  RandomStream random(1, 0, 0);
  for (std::size_t i = PhysicsModel::kRobotScene; i < physics.scenes().size(); ++i) {
    const SceneModel& scene = physics.scenes()[i];
    const mjModel& model = *scene.model;
    const DataPtr mine = make_data(model);
    const DataPtr theirs = make_data(model);
    scene.kinematics.pose_fixed(*mine);
    for (int round = 0; round < 20; ++round) {
      randomize(physics, scene, random, *mine);
      std::copy_n(mine->qpos, model.nq, theirs->qpos);
      std::copy_n(mine->mocap_pos, 3 * model.nmocap, theirs->mocap_pos);
      std::copy_n(mine->mocap_quat, 4 * model.nmocap, theirs->mocap_quat);
      scene.kinematics.pose(pose_at(physics.robot_model(), mine->qpos), *mine);
      mj_kinematics(&model, theirs.get());
      REQUIRE(difference(mine->xpos, theirs->xpos, 3 * model.nbody) < 1e-12);
      REQUIRE(difference(mine->xmat, theirs->xmat, 9 * model.nbody) < 1e-12);
      REQUIRE(difference(mine->xipos, theirs->xipos, 3 * model.nbody) < 1e-12);
      REQUIRE(difference(mine->ximat, theirs->ximat, 9 * model.nbody) < 1e-12);
      REQUIRE(difference(mine->geom_xpos, theirs->geom_xpos, 3 * model.ngeom) < 1e-12);
      REQUIRE(difference(mine->geom_xmat, theirs->geom_xmat, 9 * model.ngeom) < 1e-12);
      REQUIRE(difference(mine->xanchor, theirs->xanchor, 3 * kArmJoints) < 1e-12);
      REQUIRE(difference(mine->xaxis, theirs->xaxis, 3 * kRobotJoints) < 1e-12);
    }
  }
}

}  // namespace
}  // namespace engram
