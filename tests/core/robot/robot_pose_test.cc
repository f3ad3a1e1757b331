// Poses of the robot's links and bodies against MuJoCo's kinematics.
#include "core/robot/robot_pose.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/robot/lane_block.h"
#include "core/scene/mujoco_handle.h"
#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

TEST_CASE("Bodies that are fixed to links are where MuJoCo has them", "[physics]") {
  const mjModel& model = physics().robot();
  const DataPtr data = make_data(model);
  double worst = 0;
  for (const Robot& robot : random_robots(64)) {
    std::copy(robot.q.begin(), robot.q.end(), data->qpos);
    mj_kinematics(&model, data.get());
    const RobotPose pose = pose_at(physics().robot_model(), robot.q.data());
    for (int body = 1; body < model.nbody; ++body) {
      const Frame frame = carried(pose, attachment_of(model, body));
      const Eigen::Map<const Vec3> pos(data->xpos + 3 * body);
      const Eigen::Map<const RowMat3> axes(data->xmat + 9 * body);
      worst = std::max({worst, (frame.pos - pos).norm(), (frame.axes - axes).norm()});
    }
  }
  CHECK(worst < 1e-6);  // links' poses are floats
}

TEST_CASE("The pose in a lane is the one at its joint positions, to the bit", "[physics]") {
  LaneBlock block(widest_lane_kernel());
  const std::vector<Robot> robots = random_robots(block.lanes());
  std::fill_n(block.vectors(), LaneVectors::kCount * block.lanes(), 0.0);
  for (int lane = 0; lane < block.lanes(); ++lane) {
    const Robot& robot = robots[static_cast<std::size_t>(lane)];
    block.put(LaneVectors::kQ, lane, robot.q.data(), kRobotJoints);
    block.put(LaneVectors::kV, lane, robot.v.data(), kRobotJoints);
  }
  block.kernel().pose_links(physics().robot_model(), block.vectors());
  for (int lane = 0; lane < block.lanes(); ++lane) {
    const RobotModel& model = physics().robot_model();
    const RobotPose pose = pose_in_lane(model, block.vectors(), block.lanes(), lane);
    const RobotPose expected = pose_at(model, robots[static_cast<std::size_t>(lane)].q.data());
    for (std::size_t i = 0; i < kRobotJoints; ++i) {
      CHECK(pose.links[i].pos == expected.links[i].pos);
      CHECK(pose.links[i].axes == expected.links[i].axes);
    }
  }
}

}  // namespace
}  // namespace engram::test
