#include "core/scene/free_body.h"

namespace engram {
namespace {

constexpr double kAngularDamping = 0.05;  // 1/s
constexpr double kFastestSpin = 100;      // rad/s

Quat quat_at(const double* q) { return {q[0], q[1], q[2], q[3]}; }

}  // namespace

FreeBody::FreeBody(const mjModel& model, int body)
    : mass_(model.body_mass[body]),
      center_(Eigen::Map<const Vec3>(model.body_ipos + 3 * body)),
      inertia_(Eigen::Map<const Vec3>(model.body_inertia + 3 * body)),
      principal_(quat_at(model.body_iquat + 4 * body)) {}

FreeBodyState FreeBody::load(const double* pos, const double* quat, const double* qvel) const {
  FreeBodyState state;
  state.quat = quat_at(quat).normalized();
  const Vec3 lever = state.quat * center_;
  state.angular = state.quat * Eigen::Map<const Vec3>(qvel + 3);
  state.center = Eigen::Map<const Vec3>(pos) + lever;
  state.linear = Eigen::Map<const Vec3>(qvel) + state.angular.cross(lever);
  return state;
}

void FreeBody::store(const FreeBodyState& state, double* pos, double* quat, double* qvel) const {
  const Vec3 lever = state.quat * center_;
  Eigen::Map<Vec3>{pos} = state.center - lever;
  quat[0] = state.quat.w();
  quat[1] = state.quat.x();
  quat[2] = state.quat.y();
  quat[3] = state.quat.z();
  Eigen::Map<Vec3>{qvel} = state.linear - state.angular.cross(lever);
  Eigen::Map<Vec3>{qvel + 3} = state.quat.conjugate() * state.angular;
}

void FreeBody::accelerate(FreeBodyState& state, double gravity, double timestep) const {
  state.linear.z() -= timestep * gravity;
  state.angular *= 1 - kAngularDamping * timestep;
  const Mat3 axes = (state.quat * principal_).toRotationMatrix();
  const Vec3 spin = axes.transpose() * state.angular;
  const Vec3 momentum = inertia_.cwiseProduct(spin);
  const Vec3 turned = momentum - timestep * spin.cross(momentum);
  const double size = turned.norm();
  if (size <= 0) return;
  state.angular = axes * (turned * (momentum.norm() / size)).cwiseQuotient(inertia_);
}

Mat3 FreeBody::inv_inertia(const Quat& quat) const {
  const Mat3 axes = (quat * principal_).toRotationMatrix();
  return axes * inertia_.cwiseInverse().asDiagonal() * axes.transpose();
}

void limit_spin(FreeBodyState& state) {
  const double speed = state.angular.norm();
  if (speed > kFastestSpin) state.angular *= kFastestSpin / speed;
}

}  // namespace engram
