// One substep of the robot's nine joints, for a single robot or for many side by side: projected
// Gauss-Seidel over implicit drives, the fingers' coupling and joint limits, with positions
// advanced in every iteration (PhysX's temporal Gauss-Seidel). docs/physics.md derives it.
#pragma once

#include "core/math/simd.h"
#include "core/robot/robot_params.h"

namespace engram {
inline namespace ENGRAM_ISA {

constexpr int kSolverIterations = 15;
constexpr double kLinkDamping = 0.05;       // 1/s, of the arm's joint velocities
constexpr double kCouplingStiffness = 1e5;  // N/m, between the fingers

// Limit of joint velocities, rad/s, m/s; PhysX's as well. Free rotation is integrated explicitly,
// and wrist joints beyond it would gain energy.
constexpr double kMaxJointVelocity = 100;

constexpr int kLeftFinger = kArmJoints;
constexpr int kRightFinger = kArmJoints + 1;

// Stiffness of a joint's drive, N m/rad, N/m: none for the arm in velocity mode.
ENGRAM_INLINE double drive_stiffness(const RobotParams& params, bool velocity_mode, int joint) {
  return velocity_mode && joint < kArmJoints ? 0.0 : params.drive.stiffness;
}

// Rows may be longer than the joints are many: a single robot's are whole vectors so, and have
// zeros at their ends.
template <class V>
constexpr int kJointRow = simd::kLanesOf<V> == 1 ? kRobotJoints + 1 : kRobotJoints;
template <class V>
struct JointsOf {
  V at[kJointRow<V>] = {};
  V& operator[](int i) { return at[i]; }
  const V& operator[](int i) const { return at[i]; }
  const V* begin() const { return at; }
  const V* end() const { return at + kJointRow<V>; }
};

// row += scale * other
template <class V>
ENGRAM_INLINE void add_scaled(JointsOf<V>& row, V scale, const JointsOf<V>& other) {
  for (int i = 0; i < kJointRow<V>; ++i) row[i] += scale * other[i];
}

template <class V>
struct JointMatrixOf {
  JointsOf<V> row[kRobotJoints];
  JointsOf<V>& operator[](int i) { return row[i]; }
  const JointsOf<V>& operator[](int i) const { return row[i]; }
  const JointsOf<V>* begin() const { return row; }
  const JointsOf<V>* end() const { return row + kRobotJoints; }
};

// Gauss-Jordan elimination of a symmetric positive definite matrix, which needs no pivoting.
template <class V>
ENGRAM_INLINE void invert(JointMatrixOf<V>& m) {
  for (int k = 0; k < kRobotJoints; ++k) {
    const V pivot = 1.0 / m[k][k];
    m[k][k] = simd::broadcast<V>(1);
    for (int i = 0; i < kJointRow<V>; ++i) m[k][i] *= pivot;
    for (int i = 0; i < kRobotJoints; ++i) {
      if (i == k) continue;
      const V factor = -m[i][k];
      m[i][k] = V{};
      add_scaled(m[i], factor, m[k]);
    }
  }
}

template <class V>
struct JointSolver {
  // --- input of prepare() ---

  JointMatrixOf<V> inv_mass;            // mass matrix; prepare() inverts it
  JointsOf<V> begin_v;                  // rad/s, m/s; after damping and bias from prepare() on
  JointsOf<V> bias_force;               // Coriolis and centrifugal forces, N m, N
  JointsOf<V> drive_bias;               // stiffness * target + damping * target velocity
  double stiffness[kRobotJoints] = {};  // of each drive

  // --- output of run(); end_q begins as q ---

  JointsOf<V> end_q;  // rad, m
  JointsOf<V> end_v;  // rad/s, m/s
  // Accumulated impulses of the substep.
  JointsOf<V> drive_impulse;
  JointsOf<V> lower_impulse;  // of joint limits
  JointsOf<V> upper_impulse;

  double dt;      // of one iteration, s
  double inv_dt;  // 1 / dt
  JointsOf<V> drive_gain;
  JointsOf<V> implicit_damping;
  JointsOf<V> effective_mass;     // inverse of inv_mass's diagonal
  JointsOf<V> coupling_response;  // change of velocities by a unit of the coupling's impulse
  V coupling_gain;

  ENGRAM_INLINE void prepare(const RobotParams& params) {
    dt = params.timestep / kSolverIterations;
    inv_dt = kSolverIterations / params.timestep;
    invert(inv_mass);
    for (int i = 0; i < kRobotJoints; ++i) {
      const double resistance = params.drive.damping + dt * stiffness[i];
      drive_gain[i] = dt / (1.0 + inv_mass[i][i] * (dt * resistance));
      implicit_damping[i] = drive_gain[i] * resistance;
      effective_mass[i] = 1.0 / inv_mass[i][i];
      coupling_response[i] = inv_mass[i][kLeftFinger] - inv_mass[i][kRightFinger];
      if (i < kArmJoints) begin_v[i] *= 1 - kLinkDamping * params.timestep;
    }
    const V compliance = coupling_response[kLeftFinger] - coupling_response[kRightFinger];
    const double unit = dt * kCouplingStiffness;
    coupling_gain = unit / (1.0 + compliance * (dt * unit));
    for (int i = 0; i < kRobotJoints; ++i) {
      add_scaled(begin_v, -params.timestep * bias_force[i], inv_mass[i]);
    }
  }

  // `contact_dv`: change of velocities by contact forces in one iteration; may be null.
  // `saturated`, if not null: counts the iterations in which a drive is at its limit.
  ENGRAM_INLINE void run(const RobotParams& params, const JointsOf<V>* contact_dv,
                         JointsOf<V>* saturated) {
    const double max_impulse = params.drive.limit * params.timestep;
    JointsOf<V> velocity = begin_v;
    drive_impulse = lower_impulse = upper_impulse = {};
    bool limited = false;
    for (int iteration = 0; iteration < kSolverIterations; ++iteration) {
      if (contact_dv != nullptr) add_scaled(velocity, simd::broadcast<V>(1), *contact_dv);
      solve_coupling(velocity);
      for (int i = 0; i < kRobotJoints; ++i) {
        const V target_impulse = drive_gain[i] * (drive_bias[i] - stiffness[i] * end_q[i]);
        solve_drive(max_impulse, i, target_impulse, velocity, saturated);
        solve_limits(params, i, velocity, limited);
      }
      for (int i = 0; i < kRobotJoints; ++i) end_q[i] += dt * velocity[i];
    }
    for (int i = 0; i < kRobotJoints; ++i) {
      end_v[i] = simd::clamp(velocity[i], -kMaxJointVelocity, kMaxJointVelocity);
    }
  }

  // An undamped spring between the fingers, taken implicitly.
  ENGRAM_INLINE void solve_coupling(JointsOf<V>& velocity) const {
    const V error = end_q[kLeftFinger] - end_q[kRightFinger] +
                    dt * (velocity[kLeftFinger] - velocity[kRightFinger]);
    add_scaled(velocity, -coupling_gain * error, coupling_response);
  }

  ENGRAM_INLINE void solve_drive(double max_impulse, int i, V target_impulse, JointsOf<V>& velocity,
                                 JointsOf<V>* saturated) {
    const V unclamped = drive_impulse[i] + (target_impulse - implicit_damping[i] * velocity[i]);
    const V impulse = simd::clamp(unclamped, -max_impulse, max_impulse);
    if (saturated != nullptr) {
      (*saturated)[i] += simd::abs(unclamped) >= max_impulse ? simd::broadcast<V>(1) : V{};
    }
    add_scaled(velocity, impulse - drive_impulse[i], inv_mass[i]);
    drive_impulse[i] = impulse;
  }

  // A joint goes no faster than to its limit.
  ENGRAM_INLINE void solve_limits(const RobotParams& params, int i, JointsOf<V>& velocity,
                                  bool& limited) {
    const V to_lower = (params.lower[i] - end_q[i]) * inv_dt;
    const V to_upper = (params.upper[i] - end_q[i]) * inv_dt;
    // All lanes together decide whether limits are solved; the result is each lane's own.
    if (limited || simd::any(simd::logical_or(velocity[i]<to_lower, velocity[i]> to_upper)))
        [[unlikely]] {
      limited = true;
      const V lower = lower_impulse[i] + (to_lower - velocity[i]) * effective_mass[i];
      apply_limit(simd::max(V{}, lower), i, lower_impulse[i], velocity);
      const V upper = upper_impulse[i] + (to_upper - velocity[i]) * effective_mass[i];
      apply_limit(simd::min(V{}, upper), i, upper_impulse[i], velocity);
    }
  }

  // Limits push in one direction only.
  ENGRAM_INLINE void apply_limit(V impulse, int i, V& accumulated, JointsOf<V>& velocity) const {
    const V change = impulse - accumulated;
    const auto changes = change != V{};
    for (int k = 0; k < kJointRow<V>; ++k) {
      // Adding nothing would change the sign of a zero.
      velocity[k] = changes ? velocity[k] + change * inv_mass[i][k] : velocity[k];
    }
    accumulated = impulse;
  }
};

}  // namespace ENGRAM_ISA
}  // namespace engram
