// The robot's kernels: against MuJoCo's own stages, against RobotStep, and against one another.
#include "core/robot/lane_kernel.h"

#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <vector>

#include "core/math/random.h"
#include "core/robot/lane_block.h"
#include "core/robot/robot_model_loader.h"
#include "core/robot/robot_step.h"
#include "core/scene/physics_model.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

const PhysicsModel& physics() {
  static const PhysicsModel model(tasks::scene_source({}));
  return model;
}

struct Robot {
  JointArray q;
  JointArray v;
  DriveTarget drive;
  std::array<double, 6> twist;
};

// Anywhere between the limits, often with fingers at theirs, fast and with far targets: drives and
// limits take part.
Robot random_robot(RandomStream& random) {
  const RobotParams& law = physics().robot_params();
  Robot robot;
  const bool open = random.uniform(0, 1) < 0.3;
  for (std::size_t i = 0; i < kRobotJoints; ++i) {
    const bool finger = i >= kArmJoints;
    robot.q[i] = finger && open ? law.upper[i] : random.uniform(law.lower[i], law.upper[i]);
    robot.v[i] = finger ? random.uniform(-0.1, 0.1) : random.uniform(-2, 2);
    robot.drive.qpos[i] = robot.q[i] + random.uniform(-0.3, 0.3);
  }
  for (double& value : robot.twist) value = random.uniform(-0.1, 0.1);
  return robot;
}

void put(LaneBlock& block, int lane, const Robot& robot) {
  block.put(LaneRows::kQ, lane, robot.q.data(), kRobotJoints);
  block.put(LaneRows::kV, lane, robot.v.data(), kRobotJoints);
  block.put(LaneRows::kDisplacement, lane, robot.twist.data(), 6);
  for (int i = 0; i < kRobotJoints; ++i) {
    const double aim = drive_bias(physics().robot_params(), robot.drive, i);
    block.put(LaneRows::kDriveBias + i, lane, &aim, 1);
  }
}

// All rows of each robot, after a substep and a reach in lanes of this width.
std::vector<std::vector<double>> run(const LaneKernel& kernel, const std::vector<Robot>& robots) {
  std::vector<std::vector<double>> results;
  LaneBlock block(kernel);
  const RobotModel& chain = physics().robot_model();
  for (std::size_t first = 0; first < robots.size();
       first += static_cast<std::size_t>(block.lanes())) {
    std::fill_n(block.rows(), LaneRows::kCount * block.lanes(), 0.0);
    for (int lane = 0; lane < block.lanes(); ++lane) {
      put(block, lane, robots[first + static_cast<std::size_t>(lane)]);
    }
    kernel.substep(chain, physics().robot_params(), false, block.rows(), true);
    kernel.forward_kinematics(chain, block.rows());
    const unsigned ill = kernel.differential_ik(chain, block.rows());
    for (int lane = 0; lane < block.lanes(); ++lane) {
      std::vector<double> result(LaneRows::kCount);
      block.get(0, lane, result.data(), LaneRows::kCount);
      if ((ill >> lane & 1) != 0) {  // then the step means nothing
        std::fill_n(result.begin() + LaneRows::kStep, kArmJoints, 0.0);
      }
      results.push_back(std::move(result));
    }
  }
  return results;
}

bool same_bits(const double* a, const double* b, int count) {
  return std::equal(a, a + count, b, [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y);
  });
}

std::vector<Robot> random_robots(int count) {
  RandomStream random(5, 0, 0);
  std::vector<Robot> robots;
  robots.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) robots.push_back(random_robot(random));
  return robots;
}

TEST_CASE("Lanes of every width give the same bits", "[physics]") {
  const std::vector<Robot> robots = random_robots(4096);
  const auto alone = run(*lane_kernel(1), robots);
  for (const int lanes : {2, 4, 8}) {
    const LaneKernel* kernel = lane_kernel(lanes);
    if (kernel == nullptr) continue;
    CAPTURE(kernel->name);
    const auto beside = run(*kernel, robots);
    int different = 0;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      different += same_bits(alone[i].data(), beside[i].data(), LaneRows::kCount) ? 0 : 1;
    }
    CHECK(different == 0);
  }
}

TEST_CASE("A lane moves as RobotStep does, to the bit", "[physics]") {
  const std::vector<Robot> robots = random_robots(512);
  const auto lanes = run(widest_lane_kernel(), robots);
  int at_limits = 0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    RobotStep step(physics().robot_params(), robots[i].drive);
    step.begin(physics().robot_model(), robots[i].q.data(), robots[i].v.data());
    step.run({});
    REQUIRE(same_bits(step.end_q().data(), &lanes[i][LaneRows::kEndQ], kRobotJoints));
    REQUIRE(same_bits(step.end_v().data(), &lanes[i][LaneRows::kEndV], kRobotJoints));
    at_limits += step.end_q()[7] >= physics().robot_params().upper[7] ? 1 : 0;
  }
  CHECK(at_limits > 20);
}

TEST_CASE("Kinematics, inertia and bias forces are MuJoCo's", "[physics]") {
  const mjModel& model = physics().robot();
  const DataPtr data = make_data(model);
  const std::vector<Robot> robots = random_robots(512);
  const auto lanes = run(widest_lane_kernel(), robots);
  const int tcp = mj_name2id(&model, mjOBJ_SITE, "tcp");
  double worst = 0;
  const auto compare = [&](double ours, double theirs) {
    worst = std::max(worst, std::abs(ours - theirs));
  };
  for (std::size_t i = 0; i < robots.size(); ++i) {
    std::copy(robots[i].q.begin(), robots[i].q.end(), data->qpos);
    std::copy(robots[i].v.begin(), robots[i].v.end(), data->qvel);
    mj_kinematics(&model, data.get());
    mj_comPos(&model, data.get());
    mj_comVel(&model, data.get());
    mj_crb(&model, data.get());
    mj_rne(&model, data.get(), 0, data->qfrc_bias);
    std::vector<mjtNum> inertia(static_cast<std::size_t>(model.nv * model.nv));
    mj_fullM(&model, inertia.data(), data->qM);
    const double* ours = lanes[i].data();
    for (int k = 0; k < kRobotJoints; ++k) {
      compare(ours[LaneRows::kBiasForce + k], data->qfrc_bias[k]);
      for (int j = 0; j < kRobotJoints; ++j) {
        compare(ours[LaneRows::kMassMatrix + k * kRobotJoints + j],
                inertia[static_cast<std::size_t>(k * model.nv + j)]);
      }
    }
    for (int k = 0; k < 3; ++k) compare(ours[LaneRows::kTcp + k], data->site_xpos[3 * tcp + k]);
  }
  CHECK(worst < 1e-12);
}

TEST_CASE("Links are posed as MuJoCo poses bodies and geoms", "[physics]") {
  const SceneModel& scene = physics().scenes()[PhysicsModel::kRobotScene];
  const mjModel& model = *scene.model;
  const DataPtr mine = make_data(model);
  const DataPtr theirs = make_data(model);
  scene.kinematics.pose_fixed(*mine);
  double worst = 0;
  for (const Robot& robot : random_robots(256)) {
    std::copy(robot.q.begin(), robot.q.end(), theirs->qpos);
    mj_kinematics(&model, theirs.get());
    scene.kinematics.pose(pose_at(physics().robot_model(), robot.q.data()), *mine);
    const auto compare = [&](const mjtNum* a, const mjtNum* b, int count) {
      for (int i = 0; i < count; ++i) worst = std::max(worst, std::abs(a[i] - b[i]));
    };
    compare(mine->xpos, theirs->xpos, 3 * model.nbody);
    compare(mine->xmat, theirs->xmat, 9 * model.nbody);
    compare(mine->geom_xpos, theirs->geom_xpos, 3 * model.ngeom);
    compare(mine->geom_xmat, theirs->geom_xmat, 9 * model.ngeom);
    compare(mine->xanchor, theirs->xanchor, 3 * kArmJoints);
    compare(mine->xaxis, theirs->xaxis, 3 * kRobotJoints);
  }
  CHECK(worst < 1e-13);
}

TEST_CASE("Robots may move as far as they have room", "[physics]") {
  LaneBlock block(widest_lane_kernel());
  Robot robot = random_robots(1).front();
  for (int lane = 0; lane < block.lanes(); ++lane) {
    block.put(LaneRows::kClearanceQpos, lane, robot.q.data(), kRobotJoints);
    JointArray moved = robot.q;
    moved[0] += 0.01 * lane;
    block.put(LaneRows::kQ, lane, moved.data(), kRobotJoints);
    const double room = physics().robot_model().lever_arms[0] * 0.015;
    block.put(LaneRows::kClearance, lane, &room, 1);
  }
  const unsigned all = (1U << block.lanes()) - 1;
  CHECK(block.kernel().clearance_exceeded(physics().robot_model(), block.rows()) == (all & ~3U));
}

TEST_CASE("A robot of another build is refused", "[physics]") {
  const ModelPtr empty = compile_model("<mujoco><worldbody/></mujoco>");
  CHECK_THROWS_WITH(load_robot_model(*empty), Catch::Contains("seven hinges"));
}

}  // namespace
}  // namespace engram
