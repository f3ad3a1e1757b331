#include "tasks/common/tcp_servo.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/tasks/pose_tool.h"

namespace engram {
namespace {

using namespace tasks;

// A robot that stands where it is put.
std::unique_ptr<Batch> make_still_env() {
  return test::make_running("RememberColor3-VLA-v0", {.substeps = 0});
}

TEST_CASE("The tool tilts outwards where it must and not before", "[servo]") {
  const auto tilt_of = [](double reach, const Tilt& tilt = {}) {
    const Eigen::Vector3d point(kRobotBaseX + reach, 0, 0);
    const Eigen::Vector3d approach =
        tilt_outwards(kToolDown, point, tilt) * Eigen::Vector3d::UnitZ();
    return std::atan2(approach.x(), -approach.z());  // positive: the tips point outwards
  };
  CHECK(tilt_of(0.6) == 0);
  CHECK(tilt_of(0.78) == Approx(0.16));
  CHECK(tilt_of(1.0) == Approx(0.4));
  CHECK(tilt_of(0.28) == 0);
  CHECK(tilt_of(0.28, {.fold = 0.33}) == Approx(-0.2));
}

TEST_CASE("The servo moves towards its goal, at full scale at most", "[servo]") {
  const auto batch = make_still_env();
  test::step_at(*batch, {0.0, 0.0, 0.2});
  std::array<float, 7> action{};
  servo_tcp(batch->state(), 0, {0.01, -1.0, 0.2}, kToolDown, kGripperOpen, action.data());
  CHECK(action[0] == Approx(0.16).margin(1e-4));  // 1.6 times the distance, of 0.1 m
  CHECK(action[1] == -1);
  CHECK(action[2] == Approx(0).margin(1e-4));
  CHECK(action[6] == 1);
  hold_tcp(kGripperClosed, action.data());
  for (int i = 0; i < 6; ++i) CHECK(action[static_cast<std::size_t>(i)] == 0);
}

TEST_CASE("An approach comes down where the tool is overhead", "[servo]") {
  const auto batch = make_still_env();
  const Eigen::Vector3d goal(0.0, 0.0, 0.05);
  const auto heights = [&](const Eigen::Vector3d& tcp) {
    test::step_at(*batch, tcp);
    return std::array{approach_from_above(batch->state(), 0, goal, 0.06).z(),
                      descend(batch->state(), 0, goal, 0.115).z()};
  };
  CHECK(heights({0.1, 0.0, 0.15})[0] == Approx(0.11));
  CHECK(heights({0.1, 0.0, 0.15})[1] == Approx(0.115));  // no higher than it travels
  CHECK(heights({0.03 - 1e-6, 0.0, 0.15})[0] == Approx(0.05));
  CHECK(heights({0.03, 0.0, 0.15})[1] == Approx(0.07).margin(1e-5));
  CHECK(heights({0.005, 0.0, 0.15})[1] == Approx(0.05));
}

TEST_CASE("Low down, translations are slower", "[servo]") {
  const auto batch = make_still_env();
  const auto speed_at = [&](double height) {
    test::step_at(*batch, {0.0, 0.0, height});
    std::array<float, 7> action{0, 1, 0, 0, 0, 0, 0};
    limit_speed_near(batch->state(), 0, 0.05, action.data());
    return static_cast<double>(action[1]);
  };
  CHECK(speed_at(0.05) == Approx(0.25).margin(1e-4));
  CHECK(speed_at(0.10) == Approx(0.65).margin(1e-4));
  CHECK(speed_at(0.20) == 1);
}

// The joint action of a pose action, of full scale at most.
std::vector<float> joint_steps(const State& state, const Arm& arm,
                               const std::array<float, 7>& pose) {
  ArmJacobian jacobian;
  arm.forward(state.qpos.row(0), jacobian);
  Vector6 displacement;
  for (std::size_t i = 0; i < 6; ++i) {
    displacement[static_cast<Eigen::Index>(i)] = static_cast<double>(i < 3 ? pose[i] : -pose[i]);
  }
  ArmVector step = Arm::pseudo_inverse_step(jacobian, displacement);
  step /= std::max(1.0, step.cwiseAbs().maxCoeff());
  std::vector<float> action(step.data(), step.data() + kArmJoints);
  action.push_back(pose[6]);
  return action;
}

TEST_CASE("A tool whose orientation is free goes sideways sooner by joint steps", "[servo]") {
  const BatchOptions options{.control_mode = ControlMode::kPdJointDeltaPos,
                             .robot_init_qpos_noise = 0};
  const Eigen::Vector3d goals[] = {{0.05, 0.2, 0.3}, {-0.2, -0.25, 0.3}, {0.1, 0, 0.3}};
  for (const Eigen::Vector3d& goal : goals) {
    std::array<int, 2> steps{};  // with the orientation free, and kept
    for (const std::size_t keeps : {0U, 1U}) {
      const auto batch = test::make_running("BunchOfColors7-v0", options);
      const State& state = batch->state();
      const Arm& arm = batch->physics_model().arm();
      const auto away = [&] {
        return (Eigen::Map<const Eigen::Vector3d>(state.tcp_pos.row(0)) - goal).norm();
      };
      while (away() > 0.01 && steps[keeps] < 100) {
        std::array<float, 7> pose{};
        if (keeps != 0) {
          servo_tcp(state, 0, goal, kToolDown, kGripperOpen, pose.data());
        } else {
          reach_point(state, arm, 0, goal, kGripperOpen, pose.data());
        }
        batch->step(joint_steps(state, arm, pose));
        ++steps[keeps];
      }
      CHECK(away() <= 0.01);
    }
    CHECK(steps[0] < 0.7 * steps[1]);
  }
}

TEST_CASE("The tool's velocity is that of its way", "[servo]") {
  const auto batch = test::make_running("RememberColor3-VLA-v0");
  const State& state = batch->state();
  const Arm& arm = batch->physics_model().arm();
  double* q = state.qpos.row(0);
  for (int i = 0; i < kArmJoints; ++i) state.qvel.row(0)[i] = 0.1 * (i + 1);
  const Eigen::Vector3d velocity = tcp_velocity(state, arm, 0);
  constexpr double kStep = 1e-6;  // s
  const Eigen::Vector3d before = arm.forward(q).pos;
  for (int i = 0; i < kArmJoints; ++i) q[i] += kStep * state.qvel.row(0)[i];
  const Eigen::Vector3d after = arm.forward(q).pos;
  CHECK((velocity - (after - before) / kStep).norm() < 1e-5);
}

}  // namespace
}  // namespace engram
