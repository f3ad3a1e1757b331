// Kinematics of the serial arm: TCP pose, Jacobian, pseudo-inverse steps and inverse kinematics.
// All of it follows from the joint angles alone, never from mjData. See docs/robot.md.
#pragma once

#include "core/math/eigen_types.h"
#include "core/robot/arm_kinematics.h"

struct mjModel_;  // MuJoCo's, whose headers tasks outside of the tree can do without

namespace engram {

// A pose in the world frame. The robot's base is parallel to the world, so the orientation is the
// same in the base's frame.
struct Pose {
  Vec3 pos = Vec3::Zero();
  Quat quat = Quat::Identity();  // normalised
};

using Vector6 = Eigen::Matrix<double, 6, 1>;
using ArmVector = Eigen::Matrix<double, kArmJoints, 1>;
using ArmJacobian = Eigen::Matrix<double, 6, kArmJoints>;  // rows: linear, then angular velocity

class Arm {
 public:
  // Reads the chain that ends in the site "tcp" from a compiled model. Throws Error if the model
  // has no such site, or is not the robot that kernels know.
  explicit Arm(const mjModel_& model);

  const RobotModel& model() const { return model_; }
  // Origin of the base frame, whose axes are the world's.
  const Vec3& base_position() const { return base_position_; }

  // TCP pose for the joint angles q[7].
  Pose forward(const double* q) const;
  // TCP pose and the geometric Jacobian of the TCP origin.
  Pose forward(const double* q, ArmJacobian& jacobian) const;

  // pinv(J) * displacement: the smallest joint step that gives the displacement of the TCP.
  static ArmVector pseudo_inverse_step(const ArmJacobian& jacobian, const Vector6& displacement);
  // The joint step for a linear displacement alone: three rows of the Jacobian.
  static ArmVector pseudo_inverse_step(const ArmJacobian& jacobian, const Vec3& linear);

  // Closed-loop inverse kinematics from q by damped least squares, without joint limits: at most
  // 200 steps of 0.2 of the solution. Returns true if it ends within 1 mm and 10 mrad; false if
  // three steps in a row have not reduced the error. `q_target` is then the last step's result.
  bool inverse(const Pose& target, const double* q, ArmVector& q_target) const;

 private:
  Pose tcp_pose(const double* q, TcpJacobian<double>* jacobian) const;

  RobotModel model_;
  Vec3 base_position_;
};

// Rotation vector (axis times angle) of a unit quaternion; the shorter of both.
Vec3 rotation_vector(const Quat& quat);

// Fixed-axis roll, pitch and yaw: R = Rz(yaw) Ry(pitch) Rx(roll).
Vec3 roll_pitch_yaw(const Quat& quat);

}  // namespace engram
