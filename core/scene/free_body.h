// Motion of a free rigid body: Newton-Euler equations, integrated by semi-implicit Euler steps with
// damping implicit in velocity, as in mj_step. Velocities have MuJoCo's layout: of the body's
// origin, in world axes, then angular, in the body's axes.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <array>

namespace engram {

// Tests for a body with a free joint: physics moves it, and no joint of the robot.
bool is_free_body(const mjModel& model, int body);

// Constants of a free body, and the functions that move it.
class FreeBody {
 public:
  static constexpr int kSize = 6;  // of its velocity
  using MassMatrix = std::array<double, kSize * kSize>;

  FreeBody(const mjModel& model, int body);

  // Tests for a body at rest without applied forces.
  bool is_idle(const mjData& data) const;

  // Sets qfrc_smooth and qacc_smooth: forces and accelerations without contacts.
  void accelerate(mjData& data) const;

  MassMatrix mass_matrix(const mjData& data) const;

  // Updates the velocity, then the position with the new velocity.
  void integrate(mjData& data, double timestep) const;

 private:
  using Matrix = Eigen::Matrix3d;
  using Vector = Eigen::Vector3d;

  // Acceleration with damping at the new velocity: solves (M + h D) a = f.
  std::array<double, kSize> damped_acceleration(const mjData& data, double timestep) const;

  int body_ = 0;
  int qpos_ = 0;  // addresses
  int dof_ = 0;
  double mass_ = 0;                      // kg
  Vector center_;                        // of mass, in the body's axes, m
  Matrix inertia_;                       // about the centre of mass, in the body's axes, kg m^2
  Matrix inverse_inertia_;               // 1/(kg m^2)
  Matrix origin_inertia_;                // about the body's origin, kg m^2
  std::array<double, kSize> damping_{};  // N s/m, N m s
  bool damped_ = false;
};

// Rotates a unit quaternion (w, x, y, z) by an angular velocity in its own axes: exponential map.
void integrate_rotation(double* quat, const Eigen::Vector3d& velocity, double time);

}  // namespace engram
