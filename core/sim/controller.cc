#include "core/sim/controller.h"

#include <algorithm>
#include <cmath>

#include "core/base/index.h"
#include "core/math/real_functions.h"
#include "core/math/rotations.h"
#include "core/sim/action_dim.h"
#include "core/sim/action_scale.h"

namespace engram {
namespace {

constexpr double kVelocityScale = 1.0;  // rad/s
constexpr double kGripperMiddle = 0.015;
constexpr double kGripperScale = 0.025;

double clipped(float value) { return std::clamp(static_cast<double>(value), -1.0, 1.0); }

ArmVector measured_joints(const State& state, int env) {
  return Eigen::Map<const ArmVector>(state.qpos.row(env));
}

ArmVector clipped_joints(const float* action, double scale) {
  ArmVector values;
  for (int i = 0; i < kArmJoints; ++i) values[i] = scale * clipped(action[i]);
  return values;
}

Eigen::Vector3d clipped_translation(const float* action) {
  return kTranslationScale *
         Eigen::Vector3d(clipped(action[0]), clipped(action[1]), clipped(action[2]));
}

// Rx(a) Ry(b) Rz(c).
Eigen::Quaterniond from_xyz_euler(const Eigen::Vector3d& angles) {
  return turn_about(Eigen::Vector3d::UnitX(), angles.x()) *
         turn_about(Eigen::Vector3d::UnitY(), angles.y()) *
         turn_about(Eigen::Vector3d::UnitZ(), angles.z());
}

int arm_dim(ControlMode mode) {
  switch (mode) {
    case ControlMode::kPdEeDeltaPos:
    case ControlMode::kPdEeTargetDeltaPos:
      return 3;
    case ControlMode::kPdEeDeltaPose:
    case ControlMode::kPdEePose:
    case ControlMode::kPdEeTargetDeltaPose:
      return 6;
    case ControlMode::kPdJointPosVel:
    case ControlMode::kPdJointDeltaPosVel:
      return 2 * kArmJoints;
    default:
      return kArmJoints;
  }
}

ActionSpace make_action_space(ControlMode mode, const double* joint_ranges) {
  ActionSpace space;
  const auto dim = at(action_dim(mode));
  space.low.assign(dim, -1.0F);
  space.high.assign(dim, 1.0F);
  const bool joints = mode == ControlMode::kPdJointPos || mode == ControlMode::kPdJointPosVel;
  space.normalized = !joints && mode != ControlMode::kPdEePose;
  if (joints) {
    for (std::size_t i = 0; i < kArmJoints; ++i) {
      space.low[i] = static_cast<float>(joint_ranges[2 * i]);
      space.high[i] = static_cast<float>(joint_ranges[2 * i + 1]);
    }
  }
  if (mode == ControlMode::kPdEePose) {
    std::fill_n(space.low.begin(), 6, -INFINITY);
    std::fill_n(space.high.begin(), 6, INFINITY);
  }
  return space;
}

void write_pose(const Pose& pose, double* row) {
  const double values[7] = {pose.pos.x(),  pose.pos.y(),  pose.pos.z(), pose.quat.w(),
                            pose.quat.x(), pose.quat.y(), pose.quat.z()};
  std::copy_n(values, 7, row);
}

Pose read_pose(const double* row) {
  return {Eigen::Vector3d(row[0], row[1], row[2]),
          Eigen::Quaterniond(row[3], row[4], row[5], row[6])};
}

}  // namespace

int action_dim(ControlMode mode) { return arm_dim(mode) + 1; }

double gripper_target(double action) {
  return kGripperMiddle + kGripperScale * std::clamp(action, -1.0, 1.0);
}

double gripper_action(double opening) {
  return std::clamp((opening - kGripperMiddle) / kGripperScale, -1.0, 1.0);
}

Controller::Controller(ControlMode mode, const Arm& arm, const double* joint_ranges,
                       int rotation_sign)
    : mode_(mode),
      arm_(arm),
      rotation_sign_(rotation_sign),
      action_space_(make_action_space(mode, joint_ranges)) {}

Pose Controller::measured_pose(const State& state, int env) const {
  Pose pose = arm_.forward(state.qpos.row(env));
  pose.pos -= arm_.base_position();
  return pose;
}

void Controller::reset(const State& state, int env) const {
  std::copy_n(state.qpos.row(env), kRobotJoints, state.target_qpos.row(env));
  write_pose(measured_pose(state, env), state.target_pose.row(env));
}

Eigen::Vector3d Controller::scaled_rotation(const float* action) const {
  Eigen::Vector3d rotation(action[3], action[4], action[5]);
  const double norm = rotation.norm();
  if (norm > 1) rotation /= norm;
  return rotation_sign_ * kRotationScale * rotation;
}

ArmVector Controller::delta_pose_target(const State& state, int env, const float* action) const {
  ArmJacobian jacobian;
  arm_.forward(state.qpos.row(env), jacobian);
  return measured_joints(state, env) +
         Arm::pseudo_inverse_step(jacobian, scaled_displacement(action));
}

Eigen::Matrix<double, 6, 1> Controller::scaled_displacement(const float* action) const {
  Eigen::Matrix<double, 6, 1> displacement;
  displacement << clipped_translation(action), scaled_rotation(action);
  return displacement;
}

void Controller::delta_pose_targets(const State& state, int first, const Column<float>& actions,
                                    LaneBlock& block, std::span<DriveTarget> drives) const {
  const int count = static_cast<int>(drives.size());
  for (int lane = 0; lane < count; ++lane) {
    const auto displacement = scaled_displacement(actions.row(first + lane));
    block.put(LaneVectors::kQ, lane, state.qpos.row(first + lane), kArmJoints);
    block.put(LaneVectors::kDisplacement, lane, displacement.data(), 6);
  }
  block.pad(LaneVectors::kQ, kArmJoints, count);
  block.pad(LaneVectors::kDisplacement, 6, count);
  const unsigned ill = block.kernel().differential_ik(arm_.model(), block.vectors());
  for (int lane = 0; lane < count; ++lane) {
    ArmVector step;
    block.get(LaneVectors::kStep, lane, step.data(), kArmJoints);
    if ((ill >> lane & 1) != 0) {
      ArmJacobian jacobian;
      block.get(LaneVectors::kJacobian, lane, jacobian.data(), 6 * kArmJoints);
      step = Arm::pseudo_inverse_step(jacobian, scaled_displacement(actions.row(first + lane)));
    }
    const ArmVector target = measured_joints(state, first + lane) + step;
    std::copy_n(target.data(), kArmJoints, drives[at(lane)].qpos.begin());
  }
}

ArmVector Controller::delta_position_target(const State& state, int env,
                                            const float* action) const {
  ArmJacobian jacobian;
  arm_.forward(state.qpos.row(env), jacobian);
  return measured_joints(state, env) +
         Arm::pseudo_inverse_step(jacobian, clipped_translation(action));
}

ArmVector Controller::pose_target(const State& state, int env, const Pose& target) const {
  ArmVector joints;
  const Pose in_world{target.pos + arm_.base_position(), target.quat};
  arm_.inverse(in_world, state.qpos.row(env), joints);  // as far as it came, on failure
  return joints;
}

ArmVector Controller::absolute_pose_target(const State& state, int env, const float* action) const {
  const Pose target{Eigen::Vector3d(action[0], action[1], action[2]),
                    from_xyz_euler(Eigen::Vector3d(action[3], action[4], action[5]))};
  return pose_target(state, env, target);
}

ArmVector Controller::tracked_pose_target(const State& state, int env, const float* action,
                                          bool rotates) const {
  Pose target = read_pose(state.target_pose.row(env));
  target.pos += clipped_translation(action);
  if (rotates) {
    target.quat = (from_xyz_euler(scaled_rotation(action)) * target.quat).normalized();
  }
  write_pose(target, state.target_pose.row(env));
  return pose_target(state, env, target);
}

ArmVector Controller::target_velocity(const float* action) const {
  switch (mode_) {
    case ControlMode::kPdJointVel:
      return clipped_joints(action, kVelocityScale);
    case ControlMode::kPdJointPosVel:
      return Eigen::Map<const Eigen::Matrix<float, kArmJoints, 1>>(action + kArmJoints)
          .cast<double>();
    case ControlMode::kPdJointDeltaPosVel:
      return clipped_joints(action + kArmJoints, kVelocityScale);
    default:
      return ArmVector::Zero();
  }
}

DriveTarget Controller::last_drive(const State& state, int env, const float* action) const {
  DriveTarget drive;
  drive.velocity_mode = mode_ == ControlMode::kPdJointVel;
  const ArmVector velocity = target_velocity(action);
  std::copy_n(state.target_qpos.row(env), kRobotJoints, drive.qpos.begin());
  std::copy_n(velocity.data(), kArmJoints, drive.qvel.begin());
  return drive;
}

DriveTarget Controller::drive(const State& state, int env, const float* action) const {
  DriveTarget drive;
  ArmVector target = measured_joints(state, env);
  switch (mode_) {
    case ControlMode::kPdJointDeltaPos:
    case ControlMode::kPdJointDeltaPosVel:
      target += clipped_joints(action, kJointScale);
      break;
    case ControlMode::kPdJointPos:
    case ControlMode::kPdJointPosVel:
      target = Eigen::Map<const Eigen::Matrix<float, kArmJoints, 1>>(action).cast<double>();
      break;
    case ControlMode::kPdEeDeltaPos:
      target = delta_position_target(state, env, action);
      break;
    case ControlMode::kPdEeDeltaPose:
      target = delta_pose_target(state, env, action);
      break;
    case ControlMode::kPdEePose:
      target = absolute_pose_target(state, env, action);
      break;
    case ControlMode::kPdJointTargetDeltaPos: {
      Eigen::Map<ArmVector> tracked(state.target_qpos.row(env));
      tracked += clipped_joints(action, kJointScale);
      target = tracked;
      break;
    }
    case ControlMode::kPdEeTargetDeltaPos:
      target = tracked_pose_target(state, env, action, false);
      break;
    case ControlMode::kPdEeTargetDeltaPose:
      target = tracked_pose_target(state, env, action, true);
      break;
    case ControlMode::kPdJointVel:
      drive.velocity_mode = true;
      break;
  }
  const ArmVector velocity = target_velocity(action);
  std::copy_n(target.data(), kArmJoints, drive.qpos.begin());
  std::copy_n(velocity.data(), kArmJoints, drive.qvel.begin());
  const double finger = gripper_target(action[arm_dim(mode_)]);
  std::fill(drive.qpos.begin() + kArmJoints, drive.qpos.end(), finger);
  return drive;
}

void Controller::drive(const State& state, int first, const Column<float>& actions,
                       LaneBlock& block, std::span<DriveTarget> drives) const {
  if (mode_ == ControlMode::kPdEeDeltaPose) {
    const auto lanes = at(block.lanes());
    for (std::size_t i = 0; i < drives.size(); i += lanes) {
      delta_pose_targets(state, first + static_cast<int>(i), actions, block,
                         drives.subspan(i, std::min(lanes, drives.size() - i)));
    }
    for (std::size_t i = 0; i < drives.size(); ++i) {
      const float* action = actions.row(first + static_cast<int>(i));
      const double finger = gripper_target(action[arm_dim(mode_)]);
      std::fill(drives[i].qpos.begin() + kArmJoints, drives[i].qpos.end(), finger);
      drives[i].qvel = {};
      drives[i].velocity_mode = false;
    }
  } else {
    for (std::size_t i = 0; i < drives.size(); ++i) {
      const int env = first + static_cast<int>(i);
      drives[i] = drive(state, env, actions.row(env));
    }
  }
  for (std::size_t i = 0; i < drives.size(); ++i) {
    std::ranges::copy(drives[i].qpos, state.target_qpos.row(first + static_cast<int>(i)));
  }
}

void Controller::hold_action(const State& state, int env, float* action) const {
  std::fill_n(action, action_space_.dim(), 0.0F);
  if (action_space_.normalized) return;
  const double* qpos = state.qpos.row(env);
  if (mode_ == ControlMode::kPdEePose) {
    const Pose pose = measured_pose(state, env);
    const Eigen::Matrix3d rotation = pose.quat.toRotationMatrix();
    // Inverse of Rx(a) Ry(b) Rz(c).
    const double b = real::asin(std::clamp(rotation(0, 2), -1.0, 1.0));
    const double a = real::atan2(-rotation(1, 2), rotation(2, 2));
    const double c = real::atan2(-rotation(0, 1), rotation(0, 0));
    const double values[6] = {pose.pos.x(), pose.pos.y(), pose.pos.z(), a, b, c};
    std::transform(values, values + 6, action, [](double v) { return static_cast<float>(v); });
  } else {
    std::transform(qpos, qpos + kArmJoints, action, [](double v) { return static_cast<float>(v); });
  }
  action[action_space_.dim() - 1] = static_cast<float>(gripper_action(qpos[kArmJoints]));
}

void Controller::joint_action(const State& state, int env, const float* pose_action,
                              float* action) const {
  const float gripper = pose_action[arm_dim(ControlMode::kPdEeDeltaPose)];
  const ArmVector target = delta_pose_target(state, env, pose_action);
  ArmVector joints = target;
  if (mode_ == ControlMode::kPdJointDeltaPos) {
    const ArmVector step = (target - measured_joints(state, env)) / kJointScale;
    joints = step / std::max(step.cwiseAbs().maxCoeff(), 1.0);
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const auto at = static_cast<std::size_t>(i);
    action[i] =
        std::clamp(static_cast<float>(joints[i]), action_space_.low[at], action_space_.high[at]);
  }
  action[kArmJoints] = gripper;
}

int Controller::state_dim() const { return state_name() == nullptr ? 0 : 7; }

const char* Controller::state_name() const {
  switch (mode_) {
    case ControlMode::kPdJointTargetDeltaPos:
      return "target_qpos";
    case ControlMode::kPdEeTargetDeltaPos:
    case ControlMode::kPdEeTargetDeltaPose:
      return "target_pose";
    default:
      return nullptr;
  }
}

const double* Controller::state_row(const State& state, int env) const {
  return mode_ == ControlMode::kPdJointTargetDeltaPos ? state.target_qpos.row(env)
                                                      : state.target_pose.row(env);
}

}  // namespace engram
