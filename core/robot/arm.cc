#include "core/robot/arm.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/real_functions.h"

namespace engram {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Pseudo-inverse by a full SVD with upstream's cut-off. Rows of zeros make the matrix square, which
// spares the decomposition one of QR first, and the compiler 25 s.
template <int Rows>
ArmVector svd_step(const Eigen::Matrix<double, Rows, kArmJoints>& jacobian,
                   const Eigen::Matrix<double, Rows, 1>& displacement) {
  constexpr double kRelativeCutOff = 7 * 1.2e-7;  // float32 default of the pseudo-inverse
  using Square = Eigen::Matrix<double, kArmJoints, kArmJoints>;
  Square padded = Square::Zero();
  padded.template topRows<Rows>() = jacobian;
  const Eigen::JacobiSVD<Square, Eigen::NoQRPreconditioner> svd(
      padded, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const auto& sigma = svd.singularValues();
  ArmVector step = ArmVector::Zero();
  for (int i = 0; i < Rows; ++i) {
    if (sigma[i] <= kRelativeCutOff * sigma[0]) break;
    const double along = svd.matrixU().col(i).template head<Rows>().dot(displacement);
    step += svd.matrixV().col(i) * (along / sigma[i]);
  }
  return step;
}

}  // namespace

Pose Arm::forward(const double* q) const { return tcp_pose(q, nullptr); }

Pose Arm::forward(const double* q, ArmJacobian& jacobian) const {
  TcpJacobian<double> columns;
  const Pose pose = tcp_pose(q, &columns);
  jacobian = Eigen::Map<const ArmJacobian>(&columns.column[0][0]);
  return pose;
}

Pose Arm::tcp_pose(const double* q, TcpJacobian<double>* jacobian) const {
  const TcpPose<double> tcp = arm_forward_kinematics(model_, q, jacobian);
  return {Vec3(tcp.pos.x(), tcp.pos.y(), tcp.pos.z()) + base_position_,
          Quat(tcp.quat.w, tcp.quat.x, tcp.quat.y, tcp.quat.z)};
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Vector6& displacement) {
  TcpJacobian<double> columns;
  Eigen::Map<ArmJacobian>(&columns.column[0][0]) = jacobian;
  ArmVector step;
  if (minimum_norm_step(columns, displacement.data(), step.data())) return step;
  return svd_step<6>(jacobian, displacement);
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Vec3& linear) {
  constexpr double kWellConditioned = 1e-4;  // smallest over largest pivot
  const Eigen::Matrix<double, 3, kArmJoints> rows = jacobian.topRows<3>();
  const Mat3 normal = rows * rows.transpose();
  const Eigen::LLT<Mat3> factor(normal);
  if (factor.info() == Eigen::Success) {
    const auto pivots = factor.matrixLLT().diagonal().eval();
    if (pivots.minCoeff() > kWellConditioned * pivots.maxCoeff()) {
      return rows.transpose() * factor.solve(linear);
    }
  }
  return svd_step<3>(rows, linear);
}

bool Arm::inverse(const Pose& target, const double* q, ArmVector& q_target) const {
  constexpr int kIterations = 200;
  constexpr double kStep = 0.2;
  constexpr double kDamping = 1e-9;
  constexpr double kPositionTolerance = 1e-3;  // m
  constexpr double kRotationTolerance = 1e-2;  // rad
  constexpr int kPatience = 3;                 // steps without a smaller error
  constexpr double kLargestAngle = 1e5;        // rad; sine and cosine are exact up to here
  q_target = Eigen::Map<const ArmVector>(q);
  double min_error = std::numeric_limits<double>::infinity();
  int stalled = 0;
  ArmJacobian jacobian;
  for (int i = 0; i < kIterations; ++i) {
    const Pose pose = forward(q_target.data(), jacobian);
    Vector6 error;
    error.head<3>() = target.pos - pose.pos;
    error.tail<3>() = rotation_vector(target.quat * pose.quat.conjugate());
    const Matrix6 normal = jacobian * jacobian.transpose() + kDamping * Matrix6::Identity();
    const ArmVector next = q_target + kStep * jacobian.transpose() * normal.ldlt().solve(error);
    // Refuses numbers that are not finite as well.
    if (!(next.array().abs() <= kLargestAngle).all()) return false;
    q_target = next;
    if (error.head<3>().norm() < kPositionTolerance &&
        error.tail<3>().norm() < kRotationTolerance) {
      return true;
    }
    if (i == 0) continue;  // the original does not compare with the first error
    const double size = error.norm();
    if (size < min_error) {
      min_error = size;
      stalled = 0;
    } else if (++stalled == kPatience) {
      return false;
    }
  }
  return false;
}

Vec3 rotation_vector(const Quat& quat) {
  const double sign = quat.w() < 0 ? -1.0 : 1.0;
  const double sine = quat.vec().norm();
  if (sine < 1e-12) return 2 * sign * quat.vec();
  const double angle = 2 * real::atan2(sine, sign * quat.w());
  return quat.vec() * (sign * angle / sine);
}

Vec3 roll_pitch_yaw(const Quat& quat) {
  const double w = quat.w();
  const double x = quat.x();
  const double y = quat.y();
  const double z = quat.z();
  return {real::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)),
          real::asin(std::clamp(2 * (w * y - z * x), -1.0, 1.0)),
          real::atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))};
}

}  // namespace engram
