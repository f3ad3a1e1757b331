// The robot's kernels of all widths against one another.
#include "core/robot/lane_kernel.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/robot/lane_block.h"
#include "tests/core/robot/robot_fixture.h"

namespace engram::test {
namespace {

void put(LaneBlock& block, int lane, const Robot& robot) {
  block.put(LaneVectors::kQ, lane, robot.q.data(), kRobotJoints);
  block.put(LaneVectors::kV, lane, robot.v.data(), kRobotJoints);
  block.put(LaneVectors::kDisplacement, lane, robot.displacement.data(), 6);
  for (int i = 0; i < kRobotJoints; ++i) {
    const double bias = drive_bias_of(robot, i);
    block.put(LaneVectors::kDriveBias + i, lane, &bias, 1);
  }
}

// All rows of each robot, after a substep and differential IK in lanes of this width.
std::vector<std::vector<double>> run(const LaneKernel& kernel, const std::vector<Robot>& robots) {
  std::vector<std::vector<double>> results;
  LaneBlock block(kernel);
  const RobotModel& model = physics().robot_model();
  for (std::size_t first = 0; first < robots.size();
       first += static_cast<std::size_t>(block.lanes())) {
    std::fill_n(block.vectors(), LaneVectors::kCount * block.lanes(), 0.0);
    for (int lane = 0; lane < block.lanes(); ++lane) {
      put(block, lane, robots[first + static_cast<std::size_t>(lane)]);
    }
    kernel.substep(model, physics().robot_params(), false, block.vectors());
    kernel.forward_kinematics(model, block.vectors());
    const unsigned ill = kernel.differential_ik(model, block.vectors());
    for (int lane = 0; lane < block.lanes(); ++lane) {
      std::vector<double> result(LaneVectors::kCount);
      block.get(0, lane, result.data(), LaneVectors::kCount);
      if ((ill >> lane & 1) != 0) {  // then the step means nothing
        std::fill_n(result.begin() + LaneVectors::kStep, kArmJoints, 0.0);
      }
      results.push_back(std::move(result));
    }
  }
  return results;
}

TEST_CASE("Lanes of every width give the same bits", "[physics]") {
  const std::vector<Robot> robots = random_robots(4096);
  const auto alone = run(*lane_kernel(1), robots);
  const auto at_limit = [](const std::vector<double>& vectors) {
    return vectors[LaneVectors::kEndQ + kArmJoints] >=
           physics().robot_params().upper[kArmJoints] - 1e-9;
  };
  CHECK(std::count_if(alone.begin(), alone.end(), at_limit) > 100);
  std::vector<const LaneKernel*> kernels = {&baseline_single_kernel(), lane_kernel(4),
                                            lane_kernel(8), lane_kernel(16)};
  for (const LaneKernel* kernel : kernels) {
    if (kernel == nullptr) continue;
    CAPTURE(kernel->lanes);
    const auto beside = run(*kernel, robots);
    int different = 0;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      different += same_bits(alone[i].data(), beside[i].data(), LaneVectors::kCount) ? 0 : 1;
    }
    CHECK(different == 0);
  }
}

TEST_CASE("Kinematics in lanes are those in double precision", "[physics]") {
  std::vector<Robot> robots = random_robots(4096);
  for (std::size_t i = 0; i < robots.size(); i += 8) {  // elbows that are nearly straight
    robots[i].q[3] = physics().robot_params().upper[3] - 1e-4 * static_cast<double>(i);
  }
  const auto rows = run(widest_lane_kernel(), robots);
  double position = 0;
  double step = 0;
  int ill = 0;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    ArmJacobian jacobian;
    const Pose tcp = physics().arm().forward(robots[i].q.data(), jacobian);
    const double* const lane = rows[i].data();
    const Eigen::Map<const Vec3> in_lane(lane + LaneVectors::kTcp);
    position = std::max(position, (in_lane - tcp.pos).norm());
    const Eigen::Map<const ArmVector> step_in_lane(lane + LaneVectors::kStep);
    if (step_in_lane.isZero(0)) {  // ill conditioned
      ++ill;
      continue;
    }
    const Vector6 displacement = Eigen::Map<const Vector6>(robots[i].displacement.data());
    const ArmVector exact = Arm::pseudo_inverse_step(jacobian, displacement);
    step = std::max(step, (step_in_lane - exact).norm() / exact.norm());
  }
  CHECK(position < 1e-6);
  CHECK(step < 2e-3);
  CHECK(ill > 0);
  CHECK(ill < 400);
}

TEST_CASE("A robot that moves beyond its clearance is reported", "[physics]") {
  LaneBlock block(widest_lane_kernel());
  JointArray far;
  far.fill(1);
  Robot robot = random_robots(1).front();
  for (int lane = 0; lane < block.lanes(); ++lane) {
    block.put(LaneVectors::kClearanceQpos, lane, robot.q.data(), kRobotJoints);
    JointArray moved = robot.q;
    moved[0] += 0.01 * lane;
    block.put(LaneVectors::kQ, lane, moved.data(), kRobotJoints);
    const double clearance = physics().robot_model().lever_arms[0] * 0.015;
    block.put(LaneVectors::kClearance, lane, &clearance, 1);
    block.put(LaneVectors::kSelfClearance, lane, far.data(), kRobotJoints);
  }
  const unsigned all = (1U << block.lanes()) - 1;
  const RobotModel& model = physics().robot_model();
  CHECK(block.kernel().clearance_exceeded(model, 0, 0, block.vectors()) == (all & ~3U));
  // The first two move on: 0.01 rad in the time, less what is allowed for.
  JointArray qvel{};
  qvel[0] = 1;
  for (int lane = 0; lane < 2; ++lane) {
    block.put(LaneVectors::kV, lane, qvel.data(), kRobotJoints);
  }
  CHECK(block.kernel().clearance_exceeded(model, 0.01, 0, block.vectors()) == (all & ~1U));
  const double allowance = model.lever_arms[0] * 0.008;
  CHECK(block.kernel().clearance_exceeded(model, 0.01, allowance, block.vectors()) == (all & ~3U));
}

TEST_CASE("Only a joint and later ones use up the clearance of bodies that it moves", "[physics]") {
  LaneBlock block(widest_lane_kernel());
  const RobotModel& model = physics().robot_model();
  const Robot robot = random_robots(1).front();
  constexpr std::size_t kJoint = 4;
  const double outside = 10;
  JointArray fast;  // velocity counts for the surroundings only
  fast.fill(0.1);
  for (int lane = 0; lane < block.lanes(); ++lane) {
    block.put(LaneVectors::kClearanceQpos, lane, robot.q.data(), kRobotJoints);
    block.put(LaneVectors::kClearance, lane, &outside, 1);
    block.put(LaneVectors::kV, lane, fast.data(), kRobotJoints);
  }
  const unsigned all = (1U << block.lanes()) - 1;
  for (std::size_t joint = 0; joint < kRobotJoints; ++joint) {
    CAPTURE(joint);
    JointArray self;
    self.fill(1);
    self[kJoint] = model.lever_arms[joint] * 0.015;
    unsigned beyond = 0;
    for (int lane = 0; lane < block.lanes(); ++lane) {
      JointArray moved = robot.q;
      moved[joint] += 0.01 * (lane % 3);
      block.put(LaneVectors::kQ, lane, moved.data(), kRobotJoints);
      block.put(LaneVectors::kSelfClearance, lane, self.data(), kRobotJoints);
      if (joint >= kJoint && lane % 3 == 2) beyond |= 1U << lane;
    }
    CHECK(block.kernel().clearance_exceeded(model, 1, 0, block.vectors()) == (all & beyond));
  }
}

TEST_CASE("The widest kernel is of the best instruction set here", "[physics]") {
  const LaneKernel& widest = widest_lane_kernel();
  CHECK(is_available(widest.instruction_set));
  CHECK(lane_kernel(widest.lanes) == &widest);
  CHECK(lane_kernel(3) == nullptr);
  CHECK(lane_kernel(4)->instruction_set == InstructionSet::kBaseline);
  CHECK(is_available(lane_kernel(1)->instruction_set));
}

TEST_CASE("Few robots get a kernel that they fill", "[physics]") {
  const int widest = widest_lane_kernel().lanes;
  CHECK(lane_kernel_for(1).lanes == 1);
  CHECK(lane_kernel_for(2).lanes == 4);
  CHECK(lane_kernel_for(4).lanes == 4);
  CHECK(lane_kernel_for(5).lanes == std::min(widest, 8));
  CHECK(lane_kernel_for(9).lanes == std::min(widest, 16));
  CHECK(lane_kernel_for(1000).lanes == widest);
}

}  // namespace
}  // namespace engram::test
