#include "core/robot/arm.h"

#include <algorithm>
#include <cmath>

#include "core/math/real_functions.h"
#include "core/robot/robot_model_loader.h"

namespace engram {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// By a full SVD with upstream's cut-off.
template <int Rows>
ArmVector svd_step(const Eigen::Matrix<double, Rows, kArmJoints>& jacobian,
                   const Eigen::Matrix<double, Rows, 1>& twist) {
  constexpr double kRelativeCutOff = 7 * 1.2e-7;  // float32 default of the pseudo-inverse
  const Eigen::JacobiSVD<Eigen::Matrix<double, Rows, kArmJoints>> svd(
      jacobian, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const auto& sigma = svd.singularValues();
  ArmVector step = ArmVector::Zero();
  for (int i = 0; i < Rows; ++i) {
    if (sigma[i] <= kRelativeCutOff * sigma[0]) break;
    step += svd.matrixV().col(i) * (svd.matrixU().col(i).dot(twist) / sigma[i]);
  }
  return step;
}

}  // namespace

Arm::Arm(const mjModel& model) : chain_(load_robot_model(model)) {
  root_ = Eigen::Map<const Eigen::Vector3d>(chain_.base);
}

Pose Arm::forward(const double* q) const { return follow(q, nullptr); }

Pose Arm::forward(const double* q, ArmJacobian& jacobian) const {
  ToolJacobian<double> columns;
  Pose pose = follow(q, &columns);
  jacobian = Eigen::Map<const ArmJacobian>(&columns.column[0][0]);
  return pose;
}

Pose Arm::follow(const double* q, ToolJacobian<double>* jacobian) const {
  const ToolPose<double> tool = arm_forward_kinematics(chain_, q, jacobian);
  // In the order of operations of the kernels.
  return {Eigen::Vector3d(tool.pos.x + root_.x(), tool.pos.y + root_.y(), tool.pos.z + root_.z()),
          Eigen::Quaterniond(tool.quat.w, tool.quat.x, tool.quat.y, tool.quat.z)};
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Vector6& twist) {
  ToolJacobian<double> columns;
  Eigen::Map<ArmJacobian>(&columns.column[0][0]) = jacobian;
  ArmVector step;
  if (minimum_norm_step(columns, twist.data(), step.data())) return step;
  return svd_step<6>(jacobian, twist);
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Eigen::Vector3d& linear) {
  constexpr double kWellConditioned = 1e-4;  // smallest over largest pivot
  const Eigen::Matrix<double, 3, kArmJoints> rows = jacobian.topRows<3>();
  const Eigen::Matrix3d normal = rows * rows.transpose();
  const Eigen::LLT<Eigen::Matrix3d> factor(normal);
  if (factor.info() == Eigen::Success) {
    const auto pivots = factor.matrixLLT().diagonal().eval();
    if (pivots.minCoeff() > kWellConditioned * pivots.maxCoeff()) {
      return rows.transpose() * factor.solve(linear);
    }
  }
  return svd_step<3>(rows, linear);
}

bool Arm::inverse(const Pose& target, const double* q, ArmVector& q_target) const {
  constexpr int kIterations = 100;
  constexpr double kStep = 0.1;
  constexpr double kDamping = 1e-6;
  constexpr double kTolerance = 1e-4;
  ArmVector current = Eigen::Map<const ArmVector>(q);
  ArmJacobian jacobian;
  for (int i = 0; i <= kIterations; ++i) {
    const Pose pose = forward(current.data(), jacobian);
    Vector6 error;
    error.head<3>() = target.pos - pose.pos;
    error.tail<3>() = rotation_vector(target.quat * pose.quat.conjugate());
    if (error.norm() < kTolerance) {
      q_target = current;
      return true;
    }
    const Matrix6 normal = jacobian * jacobian.transpose() + kDamping * Matrix6::Identity();
    current += kStep * jacobian.transpose() * normal.ldlt().solve(error);
  }
  q_target = Eigen::Map<const ArmVector>(q);
  return false;
}

Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& quat) {
  const double sign = quat.w() < 0 ? -1.0 : 1.0;
  const double sine = quat.vec().norm();
  if (sine < 1e-12) return 2 * sign * quat.vec();
  const double angle = 2 * real::atan2(sine, sign * quat.w());
  return quat.vec() * (sign * angle / sine);
}

Eigen::Vector3d roll_pitch_yaw(const Eigen::Quaterniond& quat) {
  const double w = quat.w();
  const double x = quat.x();
  const double y = quat.y();
  const double z = quat.z();
  return {real::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
          real::asin(std::clamp(2 * (w * y - z * x), -1.0, 1.0)),
          real::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
}

}  // namespace engram
