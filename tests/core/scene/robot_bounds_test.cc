// The proof that the robot touches nothing, against MuJoCo's own collision detection.
#include "core/scene/robot_bounds.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <vector>

#include "core/math/random.h"
#include "core/robot/lane_block.h"
#include "core/scene/physics_model.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

// Joint angles between the limits, or near the start pose.
void random_robot(const mjModel& model, RandomStream& random, bool near_start, mjData* data) {
  const double start[] = {0, 0, 0, -2.0943951, 0, 2.0943951, 0.78539816, 0.04, 0.04};
  for (int i = 0; i < kRobotJoints; ++i) {
    const double low = model.jnt_range[2 * i];
    const double high = model.jnt_range[2 * i + 1];
    data->qpos[i] = near_start && i < kArmJoints ? start[i] + random.uniform(-0.4, 0.4)
                                                 : random.uniform(low, high);
  }
}

RobotPose pose_of(const PhysicsModel& physics, const mjData& data) {
  return pose_at(physics.robot_model(), data.qpos);
}

// Lower bound of the distance of an obstacle to one of the robot's shapes.
double distance_to(const PhysicsModel& physics, const RobotPose& pose, int shape,
                   const RobotBounds::Obstacle& obstacle) {
  const CollisionScene& scene = physics.collision();
  const CollisionShape& of = scene.shapes()[static_cast<std::size_t>(shape)];
  const Frame body = carried(pose, scene.bodies()[static_cast<std::size_t>(of.body)].attachment);
  const Frame frame = {body.pos + body.axes * of.frame.pos, body.axes * of.frame.axes};
  return sphere_clearance(of, frame, obstacle.center, obstacle.radius);
}

// Whether every lane of the widest kernel says that a robot at rest is still clear, without moving
// further, after it went from where the clearance was measured to these joint positions.
bool still_clear(const PhysicsModel& physics, const RobotBounds::Clearance& before,
                 const JointArray& qpos) {
  const LaneKernel& kernel = widest_lane_kernel();
  LaneBlock block(kernel);
  const double outside = before.outside();
  for (int lane = 0; lane < block.lanes(); ++lane) {
    block.put(LaneVectors::kQ, lane, qpos.data(), kRobotJoints);
    block.put(LaneVectors::kV, lane, JointArray{}.data(), kRobotJoints);
    block.put(LaneVectors::kClearanceQpos, lane, before.qpos.data(), kRobotJoints);
    block.put(LaneVectors::kSelfClearance, lane, before.self.data(), kRobotJoints);
    block.put(LaneVectors::kClearance, lane, &outside, 1);
  }
  const unsigned exceeded = kernel.clearance_exceeded(physics.robot_model(), 0, 0, block.vectors());
  const unsigned all = (1U << block.lanes()) - 1;
  REQUIRE((exceeded == 0 || exceeded == all));
  return exceeded == 0;
}

TEST_CASE("The robot is never called clear where it has a contact", "[proximity]") {
  const PhysicsModel physics(tasks::scene_source({}));
  const mjModel& model = physics.robot();
  const DataPtr data = make_data(model);
  RandomStream random(2, 0, 0);
  const MujocoScope scope;  // a knotted robot may have more contacts than fit
  int contacts = 0;
  int clear = 0;
  for (int round = 0; round < 20'000; ++round) {
    random_robot(model, random, round % 2 == 0, data.get());
    mj_kinematics(&model, data.get());
    mj_collision(&model, data.get());
    const bool is_clear = physics.robot_bounds().clearance(pose_of(physics, *data), {}).is_clear();
    if (data->ncon > 0) REQUIRE_FALSE(is_clear);
    contacts += data->ncon > 0 ? 1 : 0;
    clear += is_clear ? 1 : 0;
  }
  CHECK(contacts > 1000);
  CHECK(clear > 8000);  // most poses of a task, or nothing would be gained
}

TEST_CASE("The robot is never called clear where it reaches an obstacle", "[proximity]") {
  mjcf::Scene scene;
  scene.props.push_back(mjcf::cube("cube", 0.02, {1, 0, 0, 1}));
  const PhysicsModel physics(tasks::scene_source(scene));
  const mjModel& model = physics.robot();
  const DataPtr data = make_data(model);
  RandomStream random(3, 0, 0);
  int reached = 0;
  int clear = 0;
  for (int round = 0; round < 5000; ++round) {
    random_robot(model, random, true, data.get());
    mj_kinematics(&model, data.get());
    if (!physics.robot_bounds().clearance(pose_of(physics, *data), {}).is_clear()) continue;
    const int site = mj_name2id(&model, mjOBJ_SITE, "tcp");
    const Eigen::Map<const Eigen::Vector3d> tcp(data->site_xpos + 3 * site);
    for (int k = 0; k < 10; ++k) {
      const double x = random.uniform(-0.3, 0.3);
      const double y = random.uniform(-0.3, 0.3);
      const double z = random.uniform(-0.3, 0.3);
      const RobotBounds::Obstacle obstacle{tcp + Eigen::Vector3d(x, y, z), 0.036};
      const RobotPose pose = pose_of(physics, *data);
      const std::vector<int>& shapes = physics.reach_shapes();
      const bool reaches = std::any_of(shapes.begin(), shapes.end(), [&](int shape) {
        return distance_to(physics, pose, shape, obstacle) <= 0;
      });
      const bool is_clear = physics.robot_bounds().clearance(pose, {&obstacle, 1}).is_clear();
      if (reaches) REQUIRE_FALSE(is_clear);
      reached += reaches ? 1 : 0;
      clear += is_clear ? 1 : 0;
    }
  }
  CHECK(reached > 1000);
  CHECK(clear > reached);
}

TEST_CASE("The first joint turns the robot without bringing its bodies nearer", "[proximity]") {
  const PhysicsModel physics(tasks::scene_source({}));
  const RobotBounds& bounds = physics.robot_bounds();
  const DataPtr data = make_data(physics.robot());
  RandomStream random(5, 0, 0);
  int turned = 0;
  for (int round = 0; round < 1000; ++round) {
    random_robot(physics.robot(), random, true, data.get());
    mj_kinematics(&physics.robot(), data.get());
    const RobotBounds::Clearance before = bounds.clearance(pose_of(physics, *data), {});
    if (!before.is_clear()) continue;
    const double least = *std::min_element(before.self.begin() + 1, before.self.end());
    const double way = std::min(before.self[0], before.outside());
    if (least >= 0.9 * way) continue;
    JointArray qpos = before.qpos;
    qpos[0] += 0.9 * way / bounds.lever_arms()[0];
    CHECK(still_clear(physics, before, qpos));
    qpos = before.qpos;
    qpos[kArmJoints - 1] += 1.1 * way / bounds.lever_arms()[kArmJoints - 1];
    CHECK_FALSE(still_clear(physics, before, qpos));
    ++turned;
  }
  CHECK(turned > 100);
}

TEST_CASE("The robot is never called still clear where it has come to a contact", "[proximity]") {
  const PhysicsModel physics(tasks::scene_source({}));
  const RobotBounds& bounds = physics.robot_bounds();
  const mjModel& model = physics.robot();
  const DataPtr data = make_data(model);
  RandomStream random(4, 0, 0);
  const MujocoScope scope;
  int contacts = 0;
  int still = 0;
  for (int round = 0; round < 5000; ++round) {
    random_robot(model, random, round % 2 == 0, data.get());
    mj_kinematics(&model, data.get());
    const RobotBounds::Clearance before = bounds.clearance(pose_of(physics, *data), {});
    if (!before.is_clear()) continue;
    const std::vector<double> from(data->qpos, data->qpos + kRobotJoints);
    for (const double turn : {0.003, 0.03, 0.3}) {
      for (int i = 0; i < kRobotJoints; ++i) {
        const double reach = i < kArmJoints ? turn : 0.001;
        data->qpos[i] = from[static_cast<std::size_t>(i)] + random.uniform(-reach, reach);
      }
      mj_kinematics(&model, data.get());
      mj_collision(&model, data.get());
      const bool is_still_clear = still_clear(physics, before, pose_of(physics, *data).qpos);
      if (is_still_clear) REQUIRE(bounds.clearance(pose_of(physics, *data), {}).is_clear());
      if (data->ncon > 0) REQUIRE_FALSE(is_still_clear);
      contacts += data->ncon > 0 ? 1 : 0;
      still += is_still_clear ? 1 : 0;
    }
  }
  CHECK(contacts > 100);
  CHECK(still > 1000);
}

}  // namespace
}  // namespace engram
