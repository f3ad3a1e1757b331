#include "core/physics/arm.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/base/real_functions.h"
#include "core/base/sine_cosine.h"

namespace engram {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

Eigen::Quaterniond to_quat(const mjtNum* q) { return {q[0], q[1], q[2], q[3]}; }
Eigen::Vector3d to_vec(const mjtNum* v) { return {v[0], v[1], v[2]}; }

// Minimum-norm solution by way of the normal equations where they are well conditioned, and by a
// full SVD with upstream's cut-off where they are not.
template <int Rows>
ArmVector minimum_norm(const Eigen::Matrix<double, Rows, kArmJoints>& jacobian,
                       const Eigen::Matrix<double, Rows, 1>& twist) {
  constexpr double kWellConditioned = 1e-4;       // smallest over largest pivot
  constexpr double kRelativeCutOff = 7 * 1.2e-7;  // float32 default of the pseudo-inverse
  const Eigen::Matrix<double, Rows, Rows> normal = jacobian * jacobian.transpose();
  const Eigen::LLT<Eigen::Matrix<double, Rows, Rows>> factor(normal);
  if (factor.info() == Eigen::Success) {
    const auto pivots = factor.matrixLLT().diagonal().eval();
    if (pivots.minCoeff() > kWellConditioned * pivots.maxCoeff()) {
      return jacobian.transpose() * factor.solve(twist);
    }
  }
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

Arm::Arm(const mjModel& model) {
  const int site = mj_name2id(&model, mjOBJ_SITE, "tcp");
  if (site < 0) throw Error(Error::Kind::kInternal, "scene without a site named 'tcp'");

  std::vector<int> chain;  // bodies from the tool's up to the base
  for (int body = model.site_bodyid[site]; body > 0; body = model.body_parentid[body]) {
    chain.push_back(body);
  }
  std::reverse(chain.begin(), chain.end());
  root_ = to_vec(model.body_pos + 3 * chain.front());

  // Fixed bodies between two joints are folded into the next link.
  Link pending{Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()};
  const auto append = [&pending](const mjtNum* pos, const mjtNum* quat) {
    pending.offset += pending.rotation * to_vec(pos);
    pending.rotation = pending.rotation * to_quat(quat);
  };
  int joints = 0;
  for (const int body : chain) {
    append(model.body_pos + 3 * body, model.body_quat + 4 * body);
    if (model.body_jntnum[body] == 0) continue;
    if (joints == kArmJoints || model.jnt_type[model.body_jntadr[body]] != mjJNT_HINGE) {
      throw Error(Error::Kind::kInternal, "the arm above 'tcp' needs exactly seven hinges");
    }
    links_[static_cast<std::size_t>(joints++)] = pending;
    pending = {Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()};
  }
  if (joints != kArmJoints) {
    throw Error(Error::Kind::kInternal, "the arm above 'tcp' needs exactly seven hinges");
  }
  append(model.site_pos + 3 * site, model.site_quat + 4 * site);
  tool_ = pending;
}

// rotation * (cosine, 0, 0, sine), without the products that are zero.
Eigen::Quaterniond turned_about_z(const Eigen::Quaterniond& rotation, double cosine, double sine) {
  return {rotation.w() * cosine - rotation.z() * sine, rotation.x() * cosine + rotation.y() * sine,
          rotation.y() * cosine - rotation.x() * sine, rotation.z() * cosine + rotation.w() * sine};
}

// Follows the chain; visit(joint, pose) sees each joint's frame.
template <class Visit>
Pose Arm::walk(const double* q, const Visit& visit) const {
  Pose pose;
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    pose.pos += pose.quat * links_[i].offset;
    double sine = 0;
    double cosine = 0;
    sine_cosine(0.5 * q[i], sine, cosine);
    pose.quat = turned_about_z(pose.quat * links_[i].rotation, cosine, sine);
    visit(i, pose);
  }
  pose.pos += pose.quat * tool_.offset;
  pose.quat = (pose.quat * tool_.rotation).normalized();
  return pose;
}

Pose Arm::forward(const double* q) const {
  return walk(q, [](std::size_t, const Pose&) {});
}

Pose Arm::forward(const double* q, ArmJacobian& jacobian) const {
  std::array<Eigen::Vector3d, kArmJoints> origins;
  std::array<Eigen::Vector3d, kArmJoints> axes;
  Pose tool = walk(q, [&](std::size_t i, const Pose& joint) {
    origins[i] = joint.pos;
    axes[i] = joint.quat * Eigen::Vector3d::UnitZ();
  });
  for (std::size_t i = 0; i < kArmJoints; ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    jacobian.col(column).head<3>() = axes[i].cross(tool.pos - origins[i]);
    jacobian.col(column).tail<3>() = axes[i];
  }
  return tool;
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Vector6& twist) {
  return minimum_norm<6>(jacobian, twist);
}

ArmVector Arm::pseudo_inverse_step(const ArmJacobian& jacobian, const Eigen::Vector3d& linear) {
  return minimum_norm<3>(jacobian.topRows<3>(), linear);
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
