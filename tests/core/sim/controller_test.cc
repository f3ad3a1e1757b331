#include "core/sim/controller.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/collision/pair_search.h"
#include "core/math/random.h"
#include "core/scene/physics_model.h"
#include "core/sim/simulator.h"
#include "tasks/common/task_info.h"

namespace engram {
namespace {

constexpr double kPi = std::numbers::pi;

const PhysicsModel& robot_model() {
  static const PhysicsModel model(tasks::scene_source({}));
  return model;
}

// One robot without props, and a controller for it.
struct Fixture {
  explicit Fixture(ControlMode mode, int rotation_sign = -1)
      : controller(mode, robot_model().arm(), robot_model().joint_ranges(), rotation_sign) {
    const double start[] = {0, 0, 0, -2 * kPi / 3, 0, 2 * kPi / 3, kPi / 4, 0.04, 0.04};
    std::copy_n(start, kRobotJoints, state.qpos.row(0));
    controller.reset(state, 0);
  }

  ArmVector q() const { return Eigen::Map<const ArmVector>(state.qpos.row(0)); }
  Pose pose() const { return robot_model().arm().forward(state.qpos.row(0)); }
  DriveTarget drive(const std::vector<float>& action) const {
    REQUIRE(action.size() == static_cast<std::size_t>(controller.action_space().dim()));
    return controller.drive(state, 0, action.data());
  }
  // DriveTarget target relative to the arm's position.
  ArmVector change(const std::vector<float>& action) const { return target(drive(action)) - q(); }
  static ArmVector target(const DriveTarget& drive) {
    return Eigen::Map<const ArmVector>(drive.qpos.data());
  }
  // One control step.
  void step(const std::vector<float>& action) {
    REQUIRE(simulator.step(state, 0, 0, drive(action)));
  }
  std::vector<float> hold() const {
    std::vector<float> action(static_cast<std::size_t>(controller.action_space().dim()), 9.0F);
    controller.hold_action(state, 0, action.data());
    return action;
  }

  ColumnStore store{1};
  State state{store, 0, max_stored_pairs(robot_model().collision())};
  Controller controller;
  Simulator simulator{robot_model(), SimulatorOptions{}, 1, 1};
};

constexpr ControlMode kAllModes[] = {
    ControlMode::kPdJointDeltaPos,    ControlMode::kPdJointPos,
    ControlMode::kPdEeDeltaPos,       ControlMode::kPdEeDeltaPose,
    ControlMode::kPdEePose,           ControlMode::kPdJointTargetDeltaPos,
    ControlMode::kPdEeTargetDeltaPos, ControlMode::kPdEeTargetDeltaPose,
    ControlMode::kPdJointVel,         ControlMode::kPdJointPosVel,
    ControlMode::kPdJointDeltaPosVel,
};

TEST_CASE("A joint action has the drive targets of a pose action", "[controller]") {
  const std::vector<float> pose_action = {0.1F, -0.1F, 0.05F, 0.2F, 0.1F, -0.3F, -0.5F};
  const Fixture pose(ControlMode::kPdEeDeltaPose);
  const DriveTarget expected = pose.drive(pose_action);
  for (const ControlMode mode : {ControlMode::kPdJointPos, ControlMode::kPdJointDeltaPos}) {
    INFO(name_of(mode));
    const Fixture joints(mode);
    REQUIRE(joints.controller.follows_pose_actions());
    std::vector<float> action(8);
    std::copy(pose_action.begin(), pose_action.end(), action.begin());
    joints.controller.joint_action(joints.state, 0, action.data(), action.data());  // in place
    const DriveTarget found = joints.drive(action);
    for (std::size_t i = 0; i < kRobotJoints; ++i) {
      CHECK(std::abs(found.qpos[i] - expected.qpos[i]) < 1e-6);
    }
  }
  CHECK_FALSE(pose.controller.follows_pose_actions());
}

TEST_CASE("A joint action that is longer than its range keeps its direction", "[controller]") {
  const std::vector<float> pose_action = {1, -1, 1, 0, 0, 0, 1};
  const Fixture pose(ControlMode::kPdEeDeltaPose);
  const Fixture joints(ControlMode::kPdJointDeltaPos);
  const ArmVector wanted = pose.change(pose_action);
  REQUIRE(wanted.cwiseAbs().maxCoeff() > 0.11);
  std::vector<float> action(8);
  joints.controller.joint_action(joints.state, 0, pose_action.data(), action.data());
  const ArmVector found = joints.change(action);
  CHECK(std::abs(found.cwiseAbs().maxCoeff() - 0.1) < 1e-6);
  CHECK(found.normalized().dot(wanted.normalized()) > 1 - 1e-9);
}

TEST_CASE("Control modes have the published names and sizes", "[controller]") {
  const std::pair<const char*, int> table[] = {{"pd_joint_delta_pos", 8},
                                               {"pd_joint_pos", 8},
                                               {"pd_ee_delta_pos", 4},
                                               {"pd_ee_delta_pose", 7},
                                               {"pd_ee_pose", 7},
                                               {"pd_joint_target_delta_pos", 8},
                                               {"pd_ee_target_delta_pos", 4},
                                               {"pd_ee_target_delta_pose", 7},
                                               {"pd_joint_vel", 8},
                                               {"pd_joint_pos_vel", 15},
                                               {"pd_joint_delta_pos_vel", 15}};
  static_assert(std::size(kAllModes) == kControlModes);
  for (std::size_t i = 0; i < std::size(table); ++i) {
    const ControlMode mode = kAllModes[i];
    CHECK(std::string(name_of(mode)) == table[i].first);
    CHECK(find_named<ControlMode>(table[i].first) == mode);
    const Fixture fixture(mode);
    CHECK(fixture.controller.action_space().dim() == table[i].second);
    CHECK(fixture.controller.action_space().high.size() ==
          static_cast<std::size_t>(table[i].second));
    CHECK(table[i].second <= kMaxActionDim);
    CHECK(fixture.controller.mode() == mode);
  }
  CHECK_FALSE(find_named<ControlMode>("pd_ee_delta").has_value());
  CHECK_FALSE(find_named<ControlMode>("").has_value());
}

TEST_CASE("Action bounds are those of the mode", "[controller]") {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const ControlMode mode : kAllModes) {
    const Fixture fixture(mode);
    const ActionSpace& space = fixture.controller.action_space();
    INFO(name_of(mode));
    CHECK(space.low.back() == -1);
    CHECK(space.high.back() == 1);
    const bool joints = mode == ControlMode::kPdJointPos || mode == ControlMode::kPdJointPosVel;
    const bool pose = mode == ControlMode::kPdEePose;
    CHECK(space.normalized == !(joints || pose));
    for (std::size_t i = 0; i + 1 < space.low.size(); ++i) {
      const double* range = robot_model().joint_ranges() + 2 * i;
      const bool joint_bound = joints && i < kArmJoints;
      CHECK(space.low[i] == (joint_bound ? static_cast<float>(range[0]) : pose ? -kInfinity : -1));
      CHECK(space.high[i] == (joint_bound ? static_cast<float>(range[1]) : pose ? kInfinity : 1));
    }
  }
  const ActionSpace space = Fixture(ControlMode::kPdJointPos).controller.action_space();
  CHECK(space.low[3] == Approx(-3.0718));
  CHECK(space.high[3] == Approx(-0.0698));
}

TEST_CASE("A delta pose action gives the joint targets of the worked example", "[controller]") {
  struct Row {
    std::vector<float> action;
    ArmVector change;
    double finger;
  };
  const Row rows[] = {
      {{0.5F, -0.2F, -1, 0.3F, 0, 0.5F, 1},
       ArmVector{{-0.013974, 0.240072, -0.013974, 0.025537, -0.034641, 0.214535, 0.039373}},
       0.040},
      {{0, 0, 0, 0, 0, 1, -0.6F}, ArmVector{{0, 0, 0, 0, 0, 0, 0.1}}, 0},
      {{2, 0, -0.5F, 0.6F, 0, 1.2F, -1},
       ArmVector{{0.006556, 0.338946, 0.006556, 0.279993, -0.051640, 0.058953, 0.128375}},
       -0.010},
      {{0, 0, 0, 0, 0, 0, 0}, ArmVector::Zero(), 0.015},
  };
  const Fixture fixture(ControlMode::kPdEeDeltaPose);
  for (const Row& row : rows) {
    CHECK((fixture.change(row.action) - row.change).cwiseAbs().maxCoeff() < 1e-6);
    const DriveTarget drive = fixture.drive(row.action);
    CHECK(drive.qpos[7] == Approx(row.finger).margin(1e-8));
    CHECK(drive.qpos[8] == drive.qpos[7]);
    CHECK_FALSE(drive.velocity_mode);
    CHECK(std::all_of(drive.qvel.begin(), drive.qvel.end(), [](double v) { return v == 0; }));
  }
}

TEST_CASE("A delta pose action leads to the TCP of the worked example", "[controller]") {
  const Fixture fixture(ControlMode::kPdEeDeltaPose);
  const auto reached = [&](const std::vector<float>& action) {
    const ArmVector target = Fixture::target(fixture.drive(action));
    return robot_model().arm().forward(target.data());
  };
  Pose pose = reached({0.5F, -0.2F, -1, 0.3F, 0, 0.5F, 1});
  CHECK((pose.pos - Eigen::Vector3d(-0.032443, -0.019793, 0.212619)).norm() < 2e-6);
  CHECK((roll_pitch_yaw(pose.quat) - Eigen::Vector3d(3.112656, -0.000786, -0.043597)).norm() <
        2e-6);
  pose = reached({0, 0, 0, 0, 0, 1, -0.6F});
  CHECK((pose.pos - fixture.pose().pos).norm() < 1e-9);
  CHECK(roll_pitch_yaw(pose.quat).z() == Approx(-0.1));
  pose = reached({2, 0, -0.5F, 0.6F, 0, 1.2F, -1});
  CHECK((pose.pos - Eigen::Vector3d(0.022049, 0.001725, 0.250955)).norm() < 2e-6);
}

TEST_CASE("A positive rotation sign turns the hand the way the action says", "[controller]") {
  const Fixture fixture(ControlMode::kPdEeDeltaPose, +1);
  const ArmVector change = fixture.change({0, 0, 0, 0, 0, 1, -0.6F});
  CHECK((change - ArmVector{{0, 0, 0, 0, 0, 0, -0.1}}).norm() < 1e-7);
  const ArmVector target = fixture.q() + change;
  CHECK(roll_pitch_yaw(robot_model().arm().forward(target.data()).quat).z() == Approx(0.1));
}

TEST_CASE("Rotations are clipped by norm and translations by component", "[controller]") {
  const Fixture fixture(ControlMode::kPdEeDeltaPose);
  CHECK(fixture.change({5, -3, 1.5F, 0, 0, 0, 0}) == fixture.change({1, -1, 1, 0, 0, 0, 0}));
  const ArmVector clipped = fixture.change({0, 0, 0, 3, 0, 4, 0});
  CHECK((clipped - fixture.change({0, 0, 0, 0.6F, 0, 0.8F, 0})).norm() < 1e-7);
  // Norm 0.9: below 1 in norm although the sum of components is not.
  CHECK((fixture.change({0, 0, 0, 0.7F, 0, 0.5657F, 0}) * 0.5 -
         fixture.change({0, 0, 0, 0.35F, 0, 0.28285F, 0}))
            .norm() < 1e-7);
}

TEST_CASE("The gripper is commanded between closed and open in every mode", "[controller]") {
  CHECK(gripper_target(-1) == Approx(-0.01));
  CHECK(gripper_target(-0.6) == Approx(0).margin(1e-15));
  CHECK(gripper_target(0) == Approx(0.015));
  CHECK(gripper_target(1) == Approx(0.04));
  CHECK(gripper_target(7) == gripper_target(1));
  CHECK(gripper_target(-7) == gripper_target(-1));
  for (const double action : {-1.0, -0.3, 0.0, 0.8, 1.0}) {
    CHECK(gripper_action(gripper_target(action)) == Approx(action).margin(1e-12));
  }
  CHECK(gripper_action(0.05) == 1);
  CHECK(gripper_action(-0.05) == -1);
  for (const ControlMode mode : kAllModes) {
    const Fixture fixture(mode);
    std::vector<float> action = fixture.hold();
    for (const float gripper : {-3.0F, -1.0F, 0.5F, 2.0F}) {
      action.back() = gripper;
      const DriveTarget drive = fixture.drive(action);
      CHECK(drive.qpos[7] == gripper_target(static_cast<double>(gripper)));
      CHECK(drive.qpos[8] == drive.qpos[7]);
    }
  }
}

TEST_CASE("Joint modes scale, clip and add as their rows say", "[controller]") {
  const std::vector<float> deltas = {1, -0.5F, 0, 2, -7, 0.25F, 1};
  const ArmVector scaled{{0.1, -0.05, 0, 0.1, -0.1, 0.025, 0.1}};
  std::vector<float> action = deltas;
  action.push_back(0);

  CHECK((Fixture(ControlMode::kPdJointDeltaPos).change(action) - scaled).norm() < 1e-12);
  CHECK((Fixture(ControlMode::kPdJointTargetDeltaPos).change(action) - scaled).norm() < 1e-12);

  // Absolute positions are not clipped, not even to the joint limits.
  const DriveTarget absolute =
      Fixture(ControlMode::kPdJointPos).drive({1, -0.5F, 0, 2, -7, 0.25F, 1, 0});
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    CHECK(absolute.qpos[i] == static_cast<double>(deltas[i]));
  }

  const DriveTarget velocity = Fixture(ControlMode::kPdJointVel).drive(action);
  CHECK(velocity.velocity_mode);
  const ArmVector speeds{{1, -0.5, 0, 1, -1, 0.25, 1}};
  CHECK(Eigen::Map<const ArmVector>(velocity.qvel.data()) == speeds);

  std::vector<float> both = deltas;
  both.insert(both.end(), {0.5F, -2, 3, 0, 0.1F, 0, 1, 0});
  const DriveTarget pos_vel = Fixture(ControlMode::kPdJointPosVel).drive(both);
  CHECK_FALSE(pos_vel.velocity_mode);
  CHECK(pos_vel.qpos[3] == 2);
  CHECK(pos_vel.qvel[0] == 0.5);
  CHECK(pos_vel.qvel[1] == -2);  // not normalised
  const Fixture delta_fixture(ControlMode::kPdJointDeltaPosVel);
  const DriveTarget delta_vel = delta_fixture.drive(both);
  CHECK((Fixture::target(delta_vel) - delta_fixture.q() - scaled).norm() < 1e-12);
  CHECK(delta_vel.qvel[0] == 0.5);
  CHECK(delta_vel.qvel[1] == -1);
  CHECK(delta_vel.qvel[2] == 1);
}

TEST_CASE("The position mode moves the TCP and leaves its orientation free", "[controller]") {
  const Fixture fixture(ControlMode::kPdEeDeltaPos);
  ArmJacobian jacobian;
  robot_model().arm().forward(fixture.q().data(), jacobian);
  const ArmVector change = fixture.change({0.5F, -2, 0.3F, 0});
  const Eigen::Vector3d moved = jacobian.topRows<3>() * change;
  CHECK((moved - Eigen::Vector3d(0.05, -0.1, 0.03)).norm() < 1e-8);
  // The smallest such step, so it has no part that would not move the TCP.
  const Fixture pose_fixture(ControlMode::kPdEeDeltaPose);
  CHECK(change.norm() < pose_fixture.change({0.5F, -2, 0.3F, 0, 0, 0, 0}).norm());
}

TEST_CASE("The absolute pose mode goes where the action says", "[controller]") {
  const Fixture fixture(ControlMode::kPdEePose);
  const float pi = std::numbers::pi_v<float>;
  const DriveTarget drive = fixture.drive({0.585F, 0.05F, 0.28F, pi, 0.1F, -0.2F, 1});
  const Pose reached = robot_model().arm().forward(drive.qpos.data());
  CHECK((reached.pos - Eigen::Vector3d(-0.03, 0.05, 0.28)).norm() < 1e-3);
  using Eigen::AngleAxisd;
  const Eigen::Quaterniond wanted(AngleAxisd(kPi, Eigen::Vector3d::UnitX()) *
                                  AngleAxisd(0.1, Eigen::Vector3d::UnitY()) *
                                  AngleAxisd(-0.2, Eigen::Vector3d::UnitZ()));
  CHECK(reached.quat.angularDistance(wanted) < 1e-2);
  // Out of reach: the arm moves, as in the original.
  const ArmVector change = fixture.change({3, 0, 0.3F, pi, 0, 0, 1});
  CHECK(change.allFinite());
  CHECK(change.norm() > 0.1);
  // A number that is no distance: the arm holds.
  CHECK(fixture.change({1e30F, 0, 0.3F, pi, 0, 0, 1}) == ArmVector::Zero());
}

TEST_CASE("Target modes add to the target before and not to what is measured", "[controller]") {
  Fixture joints(ControlMode::kPdJointTargetDeltaPos);
  const ArmVector start = joints.q();
  const std::vector<float> action = {0.5F, 0, 0, 0, 0, 0, 0, 0};
  for (int i = 1; i <= 3; ++i) {
    CHECK(Fixture::target(joints.drive(action))[0] == Approx(start[0] + 0.05 * i));
    joints.state.qpos.row(0)[0] -= 0.01;
  }
  CHECK(std::string(joints.controller.state_name()) == "target_qpos");
  CHECK(joints.controller.state_row(joints.state, 0)[0] == Approx(start[0] + 0.15));
  joints.controller.reset(joints.state, 0);
  CHECK(joints.controller.state_row(joints.state, 0)[0] == joints.q()[0]);

  for (const bool rotates : {false, true}) {
    Fixture pose(rotates ? ControlMode::kPdEeTargetDeltaPose : ControlMode::kPdEeTargetDeltaPos);
    const Eigen::Vector3d from = pose.pose().pos;
    std::vector<float> up =
        rotates ? std::vector<float>{0, 0, 0.2F, 0, 0, 0.5F, 0} : std::vector<float>{0, 0, 0.2F, 0};
    pose.drive(up);
    const DriveTarget drive = pose.drive(up);
    const Pose reached = robot_model().arm().forward(drive.qpos.data());
    CHECK((reached.pos - from - Eigen::Vector3d(0, 0, 0.04)).norm() < 1e-3);
    CHECK(roll_pitch_yaw(reached.quat).z() == Approx(rotates ? -0.1 : 0).margin(1e-2));
    CHECK(std::string(pose.controller.state_name()) == "target_pose");
    CHECK(pose.controller.state_row(pose.state, 0)[0] == Approx(from.x() + 0.615));
    CHECK(pose.controller.state_row(pose.state, 0)[2] == Approx(from.z() + 0.04));
    pose.controller.reset(pose.state, 0);
    CHECK(pose.controller.state_row(pose.state, 0)[2] == Approx(from.z()));
  }
}

TEST_CASE("Only target modes have controller state", "[controller]") {
  for (const ControlMode mode : kAllModes) {
    const bool target = std::string(name_of(mode)).find("target") != std::string::npos;
    CHECK(Fixture(mode).controller.state_dim() == (target ? 7 : 0));
    CHECK((Fixture(mode).controller.state_name() != nullptr) == target);
  }
}

TEST_CASE("The hold action keeps the arm where it is in every mode", "[controller]") {
  RandomStream random(7, 0, 0);
  for (const ControlMode mode : kAllModes) {
    Fixture fixture(mode);
    for (int i = 0; i < kArmJoints; ++i) {
      fixture.state.qpos.row(0)[i] += 0.1 * random.normal();
    }
    fixture.controller.reset(fixture.state, 0);
    const ArmVector before = fixture.q();
    for (int i = 0; i < 40; ++i) fixture.step(fixture.hold());
    INFO(name_of(mode));
    // Actions are floats.
    CHECK((fixture.q() - before).norm() < 1e-5);
    // Absolute modes hold the fingers, too; normalised ones half close them, as in the original.
    const bool absolute = !fixture.controller.action_space().normalized;
    CHECK(fixture.state.qpos.row(0)[7] == Approx(absolute ? 0.04 : 0.015).margin(1e-3));
  }
}

TEST_CASE("The velocity mode brings joints to the commanded velocity", "[controller]") {
  Fixture fixture(ControlMode::kPdJointVel);
  const std::vector<float> action = {0.5F, -0.3F, 0.2F, 0.4F, -0.6F, 0.1F, 1, 1};
  for (int i = 0; i < 10; ++i) fixture.step(action);
  for (int i = 0; i < kArmJoints; ++i) {
    CHECK(fixture.state.qvel.row(0)[i] ==
          Approx(static_cast<double>(action[static_cast<std::size_t>(i)])).margin(0.01));
  }
}

}  // namespace
}  // namespace engram
