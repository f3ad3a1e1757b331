// Controller: maps an action row to drive targets by the control mode. See docs/robot.md.
#pragma once

#include <span>
#include <vector>

#include "core/robot/arm.h"
#include "core/robot/lane_block.h"
#include "core/robot/robot_model.h"
#include "core/sim/control_mode.h"
#include "core/sim/state.h"

namespace engram {

// Bounds of an action's components. Values beyond them are clipped where the mode is normalised
// (the rotation of pd_ee_delta_pose by its norm), and taken as they are where it is not.
struct ActionSpace {
  std::vector<float> low;
  std::vector<float> high;
  bool normalized = true;

  int dim() const { return static_cast<int>(low.size()); }
};

// Largest number of components of an action in any mode.
inline constexpr int kMaxActionDim = 2 * kArmJoints + 1;

class Controller {
 public:
  // rotation_sign: -1 turns the tool against the action's rotation, as the original benchmark does;
  // +1 turns it along. joint_ranges: (9, 2). `arm` must outlive this object.
  Controller(ControlMode mode, const Arm& arm, const double* joint_ranges, int rotation_sign);

  ControlMode mode() const { return mode_; }
  const ActionSpace& action_space() const { return action_space_; }

  // Sets the controller's own targets to the measured state.
  void reset(const State& state, int env) const;

  // Computes one control step's drive targets from the measured state and an action row.
  DriveTarget drive(const State& state, int env, const float* action) const;
  // Computes and stores them for the environments from `first` on, one for each drive.
  void drive(const State& state, int first, const Column<float>& actions, LaneBlock& block,
             std::span<DriveTarget> drives) const;

  // The drive targets of the last command; before the first one, the pose at reset. action: the
  // last action row, zeros before the first one.
  DriveTarget last_drive(const State& state, int env, const float* action) const;

  // Writes the action that holds the robot in place: all zeros, or the measured position in the
  // modes with absolute targets. `action` has action_space().dim() elements.
  void hold_action(const State& state, int env, float* action) const;

  // True in the modes that joint_action() can write actions for.
  bool follows_pose_actions() const {
    return mode_ == ControlMode::kPdJointPos || mode_ == ControlMode::kPdJointDeltaPos;
  }
  // Writes the action that has the drive targets of an action of pd_ee_delta_pose, within
  // action_space(). A longer step than it allows keeps its direction. The rows may be the same.
  void joint_action(const State& state, int env, const float* pose_action, float* action) const;

  // The controller's part of the state observation: 0 or 7 values (target modes only).
  int state_dim() const;
  const char* state_name() const;
  const double* state_row(const State& state, int env) const;

 private:
  // Poses that the controller reads, keeps and reports are in the root frame.
  Pose measured_pose(const State& state, int env) const;
  ArmVector delta_pose_target(const State& state, int env, const float* action) const;
  ArmVector delta_position_target(const State& state, int env, const float* action) const;
  ArmVector pose_target(const State& state, int env, const Pose& target) const;
  ArmVector absolute_pose_target(const State& state, int env, const float* action) const;
  ArmVector tracked_pose_target(const State& state, int env, const float* action,
                                bool rotates) const;
  Eigen::Vector3d scaled_rotation(const float* action) const;
  Eigen::Matrix<double, 6, 1> scaled_displacement(const float* action) const;
  // Target velocities of the arm's joints; zero in most modes.
  ArmVector target_velocity(const float* action) const;
  // Joint targets of pd_ee_delta_pose, in lanes: differential inverse kinematics.
  void delta_pose_targets(const State& state, int first, const Column<float>& actions,
                          LaneBlock& block, std::span<DriveTarget> drives) const;

  ControlMode mode_;
  const Arm& arm_;
  double rotation_sign_;
  ActionSpace action_space_;
};

// Returns the finger target of a gripper action in [-1, 1], m: 0.015 + 0.025 a, clipped.
double gripper_target(double action);
// Returns the action whose target is `opening` m per finger, clipped to [-1, 1].
double gripper_action(double opening);

}  // namespace engram
