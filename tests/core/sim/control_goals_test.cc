// Every control mode brings the tool to the same place, which is worked out by hand: the rest pose,
// turned about the axis of the base by half a radian.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "core/collision/pair_search.h"
#include "core/scene/physics_model.h"
#include "core/sim/controller.h"
#include "core/sim/simulator.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTurn = 0.5;       // rad
constexpr double kReach = 0.5443;   // m, of the TCP at rest, from the axis of the base
constexpr double kHeight = 0.3180;  // m
constexpr double kBaseX = -0.615;   // m, of the base in the world
constexpr double kRest[] = {0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4};

using Vec3 = Eigen::Vector3d;
using Action = std::vector<float>;

float number(double value) { return static_cast<float>(value); }

// In the root frame.
Vec3 goal_in_root() { return {kReach * std::cos(kTurn), kReach * std::sin(kTurn), kHeight}; }
Vec3 goal_in_world() { return goal_in_root() + Vec3(kBaseX, 0, 0); }

ArmVector goal_joints() {
  ArmVector q = Eigen::Map<const ArmVector>(kRest);
  q[0] = kTurn;
  return q;
}

const PhysicsModel& robot_model() {
  static const PhysicsModel model(tasks::scene_source({}));
  return model;
}

// A robot at rest that follows actions.
struct Robot {
  explicit Robot(ControlMode mode)
      : controller(mode, robot_model().arm(), robot_model().joint_ranges(), -1) {
    std::copy_n(kRest, kArmJoints, state.qpos.row(0));
    std::fill_n(state.qpos.row(0) + kArmJoints, kFingers, 0.04);
    controller.reset(state, 0);
  }
  ArmVector q() const { return Eigen::Map<const ArmVector>(state.qpos.row(0)); }
  Pose tcp() const { return robot_model().arm().forward(state.qpos.row(0)); }
  double yaw() const {  // of the tool
    return roll_pitch_yaw(tcp().quat).z();
  }
  void step(const Action& arm) {
    Action action = arm;
    action.push_back(-0.6F);  // the gripper: closed, exactly
    REQUIRE(action.size() == static_cast<std::size_t>(controller.action_space().dim()));
    REQUIRE(simulator.step(state, 0, 0, controller.drive(state, 0, action.data())));
  }

  ColumnStore store{1};
  State state{store, 0, max_stored_pairs(robot_model().collision())};
  Controller controller;
  Simulator simulator{robot_model(), SimulatorOptions{}, 1, 1};
};

// Remaining displacement, in units of a mode's scale.
Action joints_left(const Robot& robot) {
  Action action;
  for (const double left : (goal_joints() - robot.q()).eval()) action.push_back(number(left / 0.1));
  return action;
}

Action displacement_left(const Robot& robot) {
  Action action;
  for (const double left : (goal_in_world() - robot.tcp().pos).eval()) {
    action.push_back(number(left / 0.1));
  }
  return action;
}

// One number in the given joint's or axis' place, zeros elsewhere.
Action only(int count, int index, double value) {
  Action action(static_cast<std::size_t>(count), 0.0F);
  action[static_cast<std::size_t>(index)] = number(value);
  return action;
}

Action with_zeros(Action action, int count) {
  action.insert(action.end(), static_cast<std::size_t>(count), 0.0F);
  return action;
}

// Arm part of a mode's action at a step of the motion, and what it controls.
struct GoalScript {
  ControlMode mode;
  std::function<Action(const Robot&, int step)> action;
  bool turns = true;        // the tool, as the base does
  double tolerance = 1e-3;  // m, rad
};

const std::vector<GoalScript>& goal_scripts() {
  using enum ControlMode;
  static constexpr int kPaces = 10;  // in which target modes go there
  const auto pace = [](int step, double value) { return step < kPaces ? value : 0.0; };
  static const std::vector<GoalScript> all = {
      {kPdJointDeltaPos, [](const Robot& robot, int) { return joints_left(robot); }},
      {kPdJointPos,
       [](const Robot&, int) {
         const ArmVector q = goal_joints();
         Action action;
         for (const double angle : q) action.push_back(number(angle));
         return action;
       }},
      {kPdEeDeltaPos, [](const Robot& robot, int) { return displacement_left(robot); }, false},
      {kPdEeDeltaPose,
       [](const Robot& robot, int) {
         Action action = displacement_left(robot);
         const Eigen::Quaterniond goal(0, std::cos(kTurn / 2), std::sin(kTurn / 2), 0);
         const Vec3 turn = rotation_vector(goal * robot.tcp().quat.conjugate());
         for (const double angle : turn) action.push_back(number(-angle / 0.1));  // the sign
         return action;
       }},
      {kPdEePose,
       [](const Robot&, int) {
         // Tool down, then about its own axis, which points down.
         const Vec3 p = goal_in_root();
         return Action{number(p.x()), number(p.y()), number(p.z()), number(kPi), 0, number(-kTurn)};
       }},
      {kPdJointTargetDeltaPos,
       [pace](const Robot&, int step) {
         return only(kArmJoints, 0, pace(step, kTurn / kPaces / 0.1));
       }},
      {kPdEeTargetDeltaPos,
       [pace](const Robot&, int step) {
         const Vec3 displacement = (goal_in_root() - Vec3(kReach, 0, kHeight)) / kPaces / 0.1;
         return Action{number(pace(step, displacement.x())), number(pace(step, displacement.y())),
                       0};
       },
       false},
      {kPdEeTargetDeltaPose,
       [pace](const Robot&, int step) {
         const Vec3 displacement = (goal_in_root() - Vec3(kReach, 0, kHeight)) / kPaces / 0.1;
         return Action{number(pace(step, displacement.x())),
                       number(pace(step, displacement.y())),
                       0,
                       0,
                       0,
                       number(pace(step, -kTurn / kPaces / 0.1))};
       }},
      // Half a radian per second for a second.
      {kPdJointVel,
       [](const Robot&, int step) { return only(kArmJoints, 0, step < 20 ? kTurn : 0.0); }, true,
       0.01},
      {kPdJointPosVel,
       [](const Robot&, int) {
         Action action;
         for (const double angle : goal_joints()) action.push_back(number(angle));
         return with_zeros(action, kArmJoints);
       }},
      {kPdJointDeltaPosVel,
       [](const Robot& robot, int) { return with_zeros(joints_left(robot), kArmJoints); }},
  };
  return all;
}

TEST_CASE("Every control mode reaches a goal that is worked out by hand", "[controller]") {
  REQUIRE(goal_scripts().size() == kControlModes);
  for (const GoalScript& script : goal_scripts()) {
    INFO(name_of(script.mode));
    Robot robot(script.mode);
    for (int step = 0; step < 100; ++step) robot.step(script.action(robot, step));
    CHECK((robot.tcp().pos - goal_in_world()).norm() < script.tolerance);
    const Vec3 down = robot.tcp().quat * Vec3::UnitZ();
    if (script.turns) {
      CHECK(robot.yaw() == Approx(kTurn).margin(script.tolerance));
      CHECK((down + Vec3::UnitZ()).norm() < 2 * script.tolerance);
    } else if (script.mode == ControlMode::kPdEeTargetDeltaPos) {
      CHECK(robot.yaw() == Approx(0).margin(script.tolerance));
    }
    for (int finger = 0; finger < kFingers; ++finger) {
      CHECK(robot.state.qpos.row(0)[kArmJoints + finger] == Approx(0).margin(1e-3));
    }
  }
}

TEST_CASE("Poses are taken, kept and reported in the root frame", "[controller]") {
  // The base stands at x = -0.615; the TCP at rest 0.5443 before it.
  const Robot absolute(ControlMode::kPdEePose);
  Action hold(7);
  absolute.controller.hold_action(absolute.state, 0, hold.data());
  CHECK(hold[0] == Approx(kReach).margin(1e-4));
  CHECK(hold[1] == Approx(0).margin(1e-6));
  CHECK(hold[2] == Approx(kHeight).margin(1e-4));

  for (const ControlMode mode :
       {ControlMode::kPdEeTargetDeltaPos, ControlMode::kPdEeTargetDeltaPose}) {
    Robot tracking(mode);
    const double* target = tracking.controller.state_row(tracking.state, 0);
    const double rest[] = {kReach, 0, kHeight, 0, 1, 0, 0};
    for (int i = 0; i < 7; ++i) CHECK(target[i] == Approx(rest[i]).margin(1e-4));
    tracking.step(only(tracking.controller.action_space().dim() - 1, 1, 0.5));
    CHECK(target[0] == Approx(kReach).margin(1e-4));
    CHECK(target[1] == Approx(0.05));
    CHECK(target[2] == Approx(kHeight).margin(1e-4));
  }
}

}  // namespace
}  // namespace engram
