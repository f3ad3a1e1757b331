#include "core/scene/free_body.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/base/index.h"
#include "core/math/dense.h"
#include "core/math/eigen_types.h"
#include "core/math/sine_cosine.h"

namespace engram {
namespace {

using Axes = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Matrix3d cross_matrix(const Vec3& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

bool all_zero(const mjtNum* values, int count) {
  return std::all_of(values, values + count, [](mjtNum value) { return value == 0; });
}

}  // namespace

bool is_free_body(const mjModel& model, int body) {
  const int joint = model.body_jntadr[body];
  return joint >= 0 && model.jnt_type[joint] == mjJNT_FREE;
}

FreeBody::FreeBody(const mjModel& model, int body)
    : body_(body),
      qpos_(model.jnt_qposadr[model.body_jntadr[body]]),
      dof_(model.body_dofadr[body]),
      mass_(model.body_mass[body]),
      center_(Eigen::Map<const Vec3>(model.body_ipos + 3 * body)) {
  const mjtNum* quat = model.body_iquat + 4 * body;
  const Eigen::Matrix3d axes =
      Eigen::Quaterniond(quat[0], quat[1], quat[2], quat[3]).toRotationMatrix();
  const Eigen::Map<const Vec3> principal(model.body_inertia + 3 * body);
  inertia_ = axes * principal.asDiagonal() * axes.transpose();
  inverse_inertia_ = axes * principal.cwiseInverse().asDiagonal() * axes.transpose();
  const Eigen::Matrix3d lever = cross_matrix(center_);
  origin_inertia_ = inertia_ - mass_ * lever * lever;
  std::copy_n(model.dof_damping + dof_, kSize, damping_.begin());
  damped_ = !all_zero(damping_.data(), kSize);
}

bool FreeBody::is_idle(const mjData& data) const {
  return all_zero(data.qvel + dof_, kSize) && all_zero(data.qfrc_applied + dof_, kSize);
}

// Newton's equation for the centre of mass and Euler's about it. Applied forces act on the body's
// origin, around which the centre of mass revolves.
void FreeBody::accelerate(mjData& data) const {
  const Eigen::Map<const Axes> axes(data.xmat + 9 * body_);
  const Eigen::Map<const Vec3> spin(data.qvel + dof_ + 3);
  const Vec3 centripetal = spin.cross(spin.cross(center_));
  std::array<double, kSize> applied;
  const mjtNum* const velocity = data.qvel + dof_;
  for (std::size_t i = 0; i < kSize; ++i) {
    applied[i] = data.qfrc_applied[at(dof_) + i] - damping_[i] * velocity[i];
  }
  const Eigen::Map<const Vec3> force(applied.data());
  const Eigen::Map<const Vec3> torque(applied.data() + 3);
  const Vec3 about_center = torque - center_.cross(axes.transpose() * force);
  const Vec3 angular_acceleration = inverse_inertia_ * (about_center - spin.cross(inertia_ * spin));
  const Vec3 around = axes * (angular_acceleration.cross(center_) + centripetal);
  Eigen::Map<Vec3>(data.qacc_smooth + dof_) = force / mass_ - around;
  Eigen::Map<Vec3>(data.qacc_smooth + dof_ + 3) = angular_acceleration;
  Eigen::Map<Vec3>(data.qfrc_smooth + dof_) = force - mass_ * (axes * centripetal);
  Eigen::Map<Vec3>(data.qfrc_smooth + dof_ + 3) = torque - spin.cross(origin_inertia_ * spin);
}

FreeBody::MassMatrix FreeBody::mass_matrix(const mjData& data) const {
  const Eigen::Map<const Axes> axes(data.xmat + 9 * body_);
  MassMatrix values{};
  Eigen::Map<Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>> matrix(values.data());
  matrix.diagonal().head<3>().setConstant(mass_);
  matrix.bottomRightCorner<3, 3>() = origin_inertia_;
  if (!center_.isZero(0)) {
    const Eigen::Matrix3d coupling = -mass_ * axes * cross_matrix(center_);
    matrix.topRightCorner<3, 3>() = coupling;
    matrix.bottomLeftCorner<3, 3>() = coupling.transpose();
  }
  return values;
}

std::array<double, FreeBody::kSize> FreeBody::damped_acceleration(const mjData& data,
                                                                  double timestep) const {
  MassMatrix damped_mass = mass_matrix(data);
  std::array<double, kSize> result;
  std::array<double, kSize> inverse;
  for (std::size_t i = 0; i < kSize; ++i) {
    damped_mass[i * (kSize + 1)] += timestep * damping_[i];
    result[i] = data.qfrc_smooth[at(dof_) + i] + data.qfrc_constraint[at(dof_) + i];
  }
  factor(damped_mass.data(), inverse.data(), kSize);
  solve(damped_mass.data(), inverse.data(), result.data(), kSize);
  return result;
}

void FreeBody::integrate(mjData& data, double timestep) const {
  std::array<double, kSize> acceleration;
  if (damped_) {
    acceleration = damped_acceleration(data, timestep);
  } else {
    std::copy_n(data.qacc + dof_, kSize, acceleration.begin());
  }
  double* const velocity = data.qvel + dof_;
  for (std::size_t i = 0; i < kSize; ++i) velocity[i] += timestep * acceleration[i];
  for (int i = 0; i < 3; ++i) data.qpos[qpos_ + i] += timestep * velocity[i];
  integrate_rotation(data.qpos + qpos_ + 3, Eigen::Map<const Vec3>(velocity + 3), timestep);
}

void integrate_rotation(double* quat, const Eigen::Vector3d& velocity, double time) {
  constexpr double kMaxAngle = 1e4;  // rad; more is a diverged state
  const double speed = std::sqrt(velocity.x() * velocity.x() + velocity.y() * velocity.y() +
                                 velocity.z() * velocity.z());
  if (speed < mjMINVAL) return;
  double sine = 0;
  double cosine = 1;
  sine_cosine(std::min(0.5 * (time * speed), kMaxAngle), sine, cosine);
  const Vec3 v = velocity * (sine / speed);
  const double w = quat[0];
  const Vec3 u(quat[1], quat[2], quat[3]);
  double rotated[4];
  rotated[0] = w * cosine - u.dot(v);
  Eigen::Map<Vec3>(rotated + 1) = w * v + cosine * u + u.cross(v);
  const double norm = std::sqrt(rotated[0] * rotated[0] + rotated[1] * rotated[1] +
                                rotated[2] * rotated[2] + rotated[3] * rotated[3]);
  for (int i = 0; i < 4; ++i) quat[i] = rotated[i] / norm;
}

}  // namespace engram
