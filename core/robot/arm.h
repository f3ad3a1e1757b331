// Kinematics of the serial arm: TCP pose, Jacobian, pseudo-inverse steps and inverse kinematics.
// All of it follows from the joint angles alone, never from what a step left in an mjData. See
// docs/robot.md.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <array>

#include "core/robot/arm_kinematics.h"

namespace engram {

// A pose in the world frame. The robot's base is parallel to the world, so the orientation is the
// same in the base's frame.
struct Pose {
  Eigen::Vector3d pos = Eigen::Vector3d::Zero();
  Eigen::Quaterniond quat = Eigen::Quaterniond::Identity();  // normalised
};

using ArmVector = Eigen::Matrix<double, kArmJoints, 1>;
using ArmJacobian = Eigen::Matrix<double, 6, kArmJoints>;  // rows: linear, then angular velocity

class Arm {
 public:
  // Reads the chain that ends in the site "tcp" from a compiled model. Throws Error if the model
  // has no such site, or is not the robot that kernels know.
  explicit Arm(const mjModel& model);

  const RobotModel& chain() const { return chain_; }
  // Where the arm stands: origin of the root frame, whose axes are the world's.
  const Eigen::Vector3d& root() const { return root_; }

  // TCP pose for the joint angles q[7].
  Pose forward(const double* q) const;
  // The same, with the geometric Jacobian of the TCP origin.
  Pose forward(const double* q, ArmJacobian& jacobian) const;

  // pinv(J) * twist: the smallest joint step that realises the twist.
  static ArmVector pseudo_inverse_step(const ArmJacobian& jacobian,
                                       const Eigen::Matrix<double, 6, 1>& twist);
  // The same for the three linear rows only.
  static ArmVector pseudo_inverse_step(const ArmJacobian& jacobian, const Eigen::Vector3d& linear);

  // Closed-loop inverse kinematics from q: at most 100 steps of 0.1 of the damped least-squares
  // solution. Returns false, with `q_target` = q, if the SE(3) error does not fall below 1e-4.
  bool inverse(const Pose& target, const double* q, ArmVector& q_target) const;

 private:
  Pose follow(const double* q, ToolJacobian<double>* jacobian) const;

  RobotModel chain_;
  Eigen::Vector3d root_;
};

// Rotation vector (axis times angle) of a unit quaternion; the shorter way round.
Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& quat);

// Fixed-axis roll, pitch and yaw: R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Vector3d roll_pitch_yaw(const Eigen::Quaterniond& quat);

}  // namespace engram
