// Motion of a free rigid body without contacts: Newton-Euler equations about its centre of mass.
#pragma once

#include <mujoco/mujoco.h>

#include "core/math/eigen_types.h"

namespace engram {

// World axes throughout.
struct FreeBodyState {
  Vec3 center = Vec3::Zero();    // of mass, m
  Quat quat = Quat::Identity();  // of the body's axes
  Vec3 linear = Vec3::Zero();    // velocity of the centre of mass, m/s
  Vec3 angular = Vec3::Zero();   // rad/s
};

// Constants of a free body.
class FreeBody {
 public:
  FreeBody() = default;
  FreeBody(const mjModel& model, int body);

  // State from MuJoCo's coordinates, and back: position and quaternion of the body's origin; its
  // linear velocity in world axes and angular velocity in body axes.
  FreeBodyState load(const double* pos, const double* quat, const double* qvel) const;
  void store(const FreeBodyState& state, double* pos, double* quat, double* qvel) const;

  // Velocities at the substep's end without contacts: weight, angular damping, and the gyroscopic
  // torque, which keeps the size of the angular momentum.
  void accelerate(FreeBodyState& state, double gravity, double timestep) const;

  double inv_mass() const { return 1 / mass_; }  // 1/kg
  Mat3 inv_inertia(const Quat& quat) const;      // world axes, 1/(kg m^2)
  const Vec3& center() const { return center_; }

 private:
  double mass_ = 1;              // kg
  Vec3 center_ = Vec3::Zero();   // of mass, in the body's axes, m
  Vec3 inertia_ = Vec3::Ones();  // about the principal axes, kg m^2
  Quat principal_ = Quat::Identity();
};

// Limits the angular speed to PhysX's bound: the rotation of a slender body is explicit and would
// gain energy beyond it.
void limit_spin(FreeBodyState& state);

}  // namespace engram
