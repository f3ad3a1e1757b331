// The drive law in motion. See docs/robot.md.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/physics/controller.h"
#include "core/physics/model.h"
#include "core/physics/simulator.h"
#include "tasks/parts/task_info.h"

namespace engram {
namespace {

const PhysicsModel& robot_model() {
  static const PhysicsModel model(tasks::scene_source({}));
  return model;
}

struct Robot {
  explicit Robot(int substeps = 5)
      : simulator(robot_model(), SimulatorOptions{substeps, true}, 1, 1) {
    constexpr double kPi = std::numbers::pi;
    const double start[] = {0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4, 0.04, 0.04};
    std::copy_n(start, kRobotJoints, state.qpos.row(0));
    std::copy_n(start, kRobotJoints, drive.target.begin());
  }
  void step() { REQUIRE(simulator.step(state, 0, 0, drive)); }
  double q(int joint) const { return state.qpos.row(0)[joint]; }
  double v(int joint) const { return state.qvel.row(0)[joint]; }

  ColumnStore store{1};
  State state{store, 0};
  Simulator simulator;
  Drive drive;
};

TEST_CASE("The drive law has the published numbers", "[physics]") {
  CHECK(robot_model().drive_law().stiffness == 1000);
  CHECK(robot_model().drive_law().damping == 100);
  CHECK(robot_model().drive_law().limit == 100);
  CHECK(robot_model().gravity() == Approx(9.81));
}

TEST_CASE("A robot at its targets does not move", "[physics]") {
  Robot robot;
  for (int i = 0; i < 100; ++i) robot.step();
  for (int joint = 0; joint < kRobotJoints; ++joint) {
    CHECK(robot.q(joint) == Approx(robot.drive.target[static_cast<std::size_t>(joint)]));
    CHECK(std::abs(robot.v(joint)) < 1e-9);
  }
}

// 39 percent for a joint without inertia. The links' takes up to a quarter of it at the shoulder.
TEST_CASE("A joint covers about a third of a command in one control step", "[physics]") {
  for (int joint = 0; joint < kArmJoints; ++joint) {
    Robot robot;
    const double from = robot.q(joint);
    robot.drive.target[static_cast<std::size_t>(joint)] += 0.05;
    robot.step();
    INFO("joint " << joint);
    const double fraction = (robot.q(joint) - from) / 0.05;
    CHECK(fraction > (joint < 3 ? 0.28 : 0.34));
    CHECK(fraction < 0.42);
  }
}

// Fingers are a known mass on a straight line, so the force follows from their acceleration.
TEST_CASE("The force of a drive never exceeds its limit", "[physics]") {
  const DriveLaw law = robot_model().drive_law();
  const double dt = 0.01;
  const mjModel& model = robot_model().robot();
  // Implicit damping weighs like a mass of dt times the damping.
  const double inertia = 0.015 + model.dof_armature[7] + dt * model.dof_damping[7];
  for (const double start_speed : {0.0, 0.8, -0.8, -3.0, 3.0}) {
    Robot robot(1);
    for (const int finger : {7, 8}) {
      robot.state.qpos.row(0)[finger] = 0.02;
      robot.state.qvel.row(0)[finger] = start_speed;
      robot.drive.target[static_cast<std::size_t>(finger)] = 2.0;  // far beyond
    }
    const double q = robot.q(7);
    const double v = robot.v(7);
    robot.step();
    // What the law asks for; its damping is taken implicitly.
    const double force =
        std::clamp(law.stiffness * (2.0 - q) - law.damping * v, -law.limit, law.limit);
    const double expected = v + dt * force / inertia;
    INFO("start speed " << start_speed);
    CHECK(robot.v(7) == Approx(expected).epsilon(1e-3));
    CHECK(std::abs(inertia * (robot.v(7) - v) / dt) <= law.limit * 1.001);
    CHECK(inertia > 1);
  }
}

TEST_CASE("A saturated arm joint accelerates with the limit and not with the spring alone",
          "[physics]") {
  Robot slow(1);
  Robot saturated(1);
  slow.drive.target[6] += 0.1;       // exactly the limit
  saturated.drive.target[6] += 1.0;  // ten times the limit
  slow.step();
  saturated.step();
  CHECK(saturated.v(6) == Approx(slow.v(6)).epsilon(1e-9));  // both get 100 N m at rest
  // Later the first one brakes while the other is still pushed with 100 N m net of its damping.
  for (int i = 0; i < 4; ++i) {
    slow.step();
    saturated.step();
  }
  CHECK(saturated.v(6) > slow.v(6));
}

TEST_CASE("A full scale action moves the TCP some centimetres in its first step", "[physics]") {
  // Without inertia it would be three to four; the links' inertia and the force limit take a part.
  for (int axis = 0; axis < 3; ++axis) {
    for (const float sign : {-1.0F, 1.0F}) {
      Robot robot;
      const Controller controller(ControlMode::kPdEeDeltaPose, robot_model().arm(),
                                  robot_model().joint_ranges(), -1);
      std::vector<float> action(7);
      action[static_cast<std::size_t>(axis)] = sign;
      const Eigen::Vector3d from = robot_model().arm().forward(robot.state.qpos.row(0)).pos;
      robot.drive = controller.drive(robot.state, 0, action.data());
      robot.step();
      const Eigen::Vector3d moved = robot_model().arm().forward(robot.state.qpos.row(0)).pos - from;
      INFO("axis " << axis << " sign " << sign);
      CHECK(static_cast<double>(sign) * moved[axis] > 0.024);
      CHECK(static_cast<double>(sign) * moved[axis] < 0.042);
    }
  }
}

TEST_CASE("The gripper closes in three to four control steps and opens as fast", "[physics]") {
  Robot robot;
  const auto command = [&](double opening) {
    std::fill(robot.drive.target.begin() + kArmJoints, robot.drive.target.end(), opening);
  };
  command(0.015);
  for (int i = 0; i < 3; ++i) robot.step();
  CHECK(robot.q(7) == Approx(0.02).margin(0.003));
  command(-0.01);
  for (int i = 0; i < 4; ++i) robot.step();
  CHECK(robot.q(7) < 0.003);
  CHECK(robot.q(7) == Approx(robot.q(8)).margin(1e-4));
  for (int i = 0; i < 20; ++i) robot.step();
  CHECK(robot.q(7) > -0.001);  // the joint limit holds
}

TEST_CASE("Coupled fingers give way to one another when only one is pushed", "[physics]") {
  Robot robot;
  robot.drive.target[7] = 0.01;
  robot.drive.target[8] = 0.03;
  for (int i = 0; i < 20; ++i) robot.step();
  CHECK(robot.q(7) + robot.q(8) == Approx(0.04).margin(1e-4));
  CHECK(robot.q(8) - robot.q(7) < 0.3 * 0.02);  // apart they would be 0.02 m
}

TEST_CASE("Zero substeps leave the state alone", "[physics]") {
  Robot robot(0);
  robot.drive.target[0] = 1;
  const double before = robot.q(0);
  robot.step();
  CHECK(robot.q(0) == before);
}

}  // namespace
}  // namespace engram
