// Poses of cameras against MuJoCo's.
#include "core/image/camera_poses.h"

#include <catch2/catch.hpp>

#include "core/batch/queries.h"
#include "core/scene/mujoco_handle.h"
#include "tests/core/robot/robot_fixture.h"
#include "tests/env_helpers.h"

namespace engram::test {
namespace {

TEST_CASE("Cameras are where MuJoCo has them", "[render]") {
  const auto batch = make_env("RememberColor9-VLA-v0");
  const ModelPtr model = compile_model(Queries(*batch).document());
  const DataPtr data = make_data(*model);
  const CameraPoses cameras(Queries(*batch).document(), batch->physics_model());
  REQUIRE(model->ncam > 1);
  for (const Robot& robot : random_robots(16)) {
    std::copy(robot.q.begin(), robot.q.end(), data->qpos);
    mj_kinematics(model.get(), data.get());
    mj_comPos(model.get(), data.get());
    mj_camlight(model.get(), data.get());
    for (int i = 0; i < model->ncam; ++i) {
      const Eigen::Isometry3d pose = cameras.pose(i, robot.q.data());
      CHECK((pose.translation() - Eigen::Map<Vec3>(data->cam_xpos + 3 * i)).norm() < 1e-6);
      CHECK((pose.linear() - Eigen::Map<RowMat3>(data->cam_xmat + 9 * i)).norm() < 2e-6);
    }
  }
}

TEST_CASE("An unknown camera is refused by name", "[render]") {
  const auto batch = make_env("RememberColor9-VLA-v0");
  const CameraPoses cameras(Queries(*batch).document(), batch->physics_model());
  CHECK_THROWS_WITH(cameras.find("nowhere"), Catch::Contains("nowhere"));
}

}  // namespace
}  // namespace engram::test
