// Motion of a free body: the equations of Newton and Euler. Velocities as MuJoCo has them: of the
// body's origin, in world axes, then angular, in the body's axes.
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Dense>
#include <array>

namespace engram {

// Tells whether a body is moved by physics and by no joint of the robot.
bool is_free_body(const mjModel& model, int body);

// What is the same in every substep.
class FreeBody {
 public:
  static constexpr int kSize = 6;  // of its velocity
  using MassMatrix = std::array<double, kSize * kSize>;

  FreeBody(const mjModel& model, int body);

  // Whether it stands still and nothing pulls at it.
  bool is_idle(const mjData& data) const;

  // Sets qfrc_smooth and qacc_smooth, without contacts.
  void accelerate(mjData& data) const;

  MassMatrix mass_matrix(const mjData& data) const;

  // Velocity first, then position with the new velocity; damping taken implicitly.
  void integrate(mjData& data, double timestep) const;

 private:
  using Matrix = Eigen::Matrix3d;
  using Vector = Eigen::Vector3d;

  // Acceleration with damping, which resists with all the velocity that comes.
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

// Turns a unit quaternion (w, x, y, z) by an angular velocity in its own axes.
void turn(double* quat, const Eigen::Vector3d& velocity, double time);

}  // namespace engram
