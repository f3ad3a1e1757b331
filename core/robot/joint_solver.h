// One substep of the robot's nine joints, for a single robot or for many side by side: projected
// Gauss-Seidel over contacts, the fingers' tendon, implicit drives and joint limits, with positions
// advanced in every iteration (PhysX's temporal Gauss-Seidel). docs/physics.md has the equations.
#pragma once

#include "core/robot/joint_rows.h"

namespace engram {
inline namespace ENGRAM_ISA {

constexpr int kSolverIterations = 15;
constexpr double kLinkDamping = 0.05;     // 1/s, of the arm's joint velocities
constexpr double kTendonStiffness = 1e5;  // N/m, between the fingers
// Share of an overlap that is taken out in one iteration: 2 sqrt(1 / kSolverIterations).
constexpr double kOverlapShare = 0.5163977794943222;

// Limit of joint velocities, rad/s, m/s; PhysX's as well. Free rotation is integrated explicitly,
// and wrist joints beyond it would gain energy.
constexpr double kMaxJointVelocity = 100;

constexpr int kLeftFinger = kArmJoints;
constexpr int kRightFinger = kArmJoints + 1;

// Stiffness of a joint's drive, N m/rad, N/m: none for the arm in velocity mode.
ENGRAM_INLINE double drive_stiffness(const RobotParams& params, bool velocity_mode, int joint) {
  return velocity_mode && joint < kArmJoints ? 0.0 : params.drive.stiffness;
}

// Contacts of a robot that touches nothing.
template <class V>
struct NoContacts {
  // Pairs of a moving body with a link or another moving body, then of moving bodies with fixed
  // ones. `last`: the velocity iteration.
  ENGRAM_INLINE void solve_bodies(JointsOf<V>& /*velocity*/, bool /*last*/) {}
  ENGRAM_INLINE void move_bodies() {}
  // Contacts with fixed bodies of the links that move with a joint and no later one.
  ENGRAM_INLINE void solve_links(int /*joint*/, JointsOf<V>& /*velocity*/, bool /*last*/) {}
  ENGRAM_INLINE void move_links(const JointsOf<V>& /*q*/) {}
};

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
  JointsOf<V> tendon_response;  // change of velocities by a unit of the tendon's error

  // Limits of joints are compliant; known once a joint comes to its limit.
  JointsOf<V> limit_mass;
  bool limit_known[kRobotJoints] = {};

  ENGRAM_INLINE void prepare(const RobotParams& params) {
    dt = params.timestep / kSolverIterations;
    inv_dt = kSolverIterations / params.timestep;
    invert(inv_mass);
    for (int i = 0; i < kRobotJoints; ++i) {
      const double resistance = params.drive.damping + dt * stiffness[i];
      drive_gain[i] = dt / (1.0 + inv_mass[i][i] * (dt * resistance));
      implicit_damping[i] = drive_gain[i] * resistance;
      if (i < kArmJoints) begin_v[i] *= 1 - kLinkDamping * params.timestep;
    }
    const double unit = dt * kTendonStiffness;
    const V left = unit / (1.0 + dt * unit * inv_mass[kLeftFinger][kLeftFinger]);
    const V right = unit / (1.0 + dt * unit * inv_mass[kRightFinger][kRightFinger]);
    for (int i = 0; i < kJointRow<V>; ++i) {
      tendon_response[i] = right * inv_mass[kRightFinger][i] - left * inv_mass[kLeftFinger][i];
    }
    for (int i = 0; i < kRobotJoints; ++i) {
      add_scaled(begin_v, -params.timestep * bias_force[i], inv_mass[i]);
    }
    // No velocity is a negative zero, so that adding a zero impulse never changes a bit.
    for (int i = 0; i < kJointRow<V>; ++i) begin_v[i] += V{};
  }

  // `frames`: LinkFrames at the substep's start, for the compliance of limits.
  template <class Frames, class Contacts>
  ENGRAM_INLINE void run(const RobotParams& params, const Frames& frames, Contacts& contacts) {
    const double max_impulse = params.drive.limit * params.timestep;
    JointsOf<V> velocity = begin_v;
    drive_impulse = lower_impulse = upper_impulse = {};
    for (bool& known : limit_known) known = false;
    for (int iteration = 0; iteration < kSolverIterations; ++iteration) {
      contacts.solve_bodies(velocity, false);
      contacts.move_bodies();
      solve_tendon(velocity);
      for_each_joint([&](auto joint) ENGRAM_INLINE_LAMBDA {
        solve_drive(max_impulse, joint, velocity);
        solve_limits(params, frames, joint, velocity, false);
        contacts.solve_links(joint, velocity, false);
      });
      integrate(params, velocity);
      contacts.move_links(end_q);
    }
    // The velocity iteration: overlaps push no more, and nothing moves.
    contacts.solve_bodies(velocity, true);
    solve_tendon(velocity);
    for_each_joint([&](auto joint) ENGRAM_INLINE_LAMBDA {
      solve_limits(params, frames, joint, velocity, true);
      contacts.solve_links(joint, velocity, true);
    });
    for (int i = 0; i < kRobotJoints; ++i) {
      end_v[i] = simd::clamp(velocity[i], -kMaxJointVelocity, kMaxJointVelocity);
    }
  }

  // Fingers stop at their limits; joints of the arm do not.
  ENGRAM_INLINE void integrate(const RobotParams& params, const JointsOf<V>& velocity) {
    for_each_joint([&](auto i) ENGRAM_INLINE_LAMBDA {
      end_q[i] += dt * velocity[i];
      if (i >= kArmJoints) end_q[i] = simd::clamp(end_q[i], params.lower[i], params.upper[i]);
    });
  }

  // An undamped spring on the mean of both fingers' errors, taken implicitly for each finger alone.
  ENGRAM_INLINE void solve_tendon(JointsOf<V>& velocity) const {
    const V error = 0.5 * (end_q[kLeftFinger] - end_q[kRightFinger] +
                           dt * (velocity[kLeftFinger] - velocity[kRightFinger]));
    add_scaled(velocity, error, tendon_response);
  }

  // The velocities of all joints but one wait for that one: what is not on the way from a velocity
  // to the next one's decides nothing, so the limit of the drive is a branch.
  ENGRAM_INLINE void solve_drive(double max_impulse, int i, JointsOf<V>& velocity) {
    const V target_impulse = drive_gain[i] * (drive_bias[i] - stiffness[i] * end_q[i]);
    const V before = drive_impulse[i];
    V impulse = before + (target_impulse - implicit_damping[i] * velocity[i]);
    if (simd::any(simd::abs(impulse) > max_impulse)) [[unlikely]] {
      impulse = simd::clamp(impulse, -max_impulse, max_impulse);
    }
    add_scaled(velocity, impulse - before, inv_mass[i]);
    drive_impulse[i] = impulse;
  }

  // A joint goes no faster than to its limit. All lanes together decide whether limits are solved;
  // the result is each lane's own.
  template <class Frames>
  ENGRAM_INLINE void solve_limits(const RobotParams& params, const Frames& frames, int i,
                                  JointsOf<V>& velocity, bool last) {
    const V above = end_q[i] - params.lower[i];
    const V below = params.upper[i] - end_q[i];
    const V way = dt * velocity[i];
    if (!limit_known[i] && !simd::any(simd::min(above, below) < simd::abs(way))) [[likely]]
      return;
    const auto at_lower = simd::logical_or(above < 0.0, above + way < 0.0);
    const auto at_upper = simd::logical_or(below < 0.0, below - way < 0.0);
    if (!limit_known[i]) {
      if (!simd::any(simd::logical_or(at_lower, at_upper))) return;
      find_limit_mass(frames, i);
    }
    add_scaled(velocity, limit_impulse(i, velocity[i], above, below, at_lower, at_upper, last),
               inv_mass[i]);
  }

  template <class Frames>
  [[gnu::noinline, gnu::cold]] void find_limit_mass(const Frames& frames, int i) {
    limit_known[i] = true;
    limit_mass[i] = 1.0 / (inv_mass[i][i] + frames.joint_compliance(i, inv_mass));
  }

  // Change of the impulse of a joint's limits. A limit that the joint leaves lets go of it.
  template <class Mask>
  ENGRAM_INLINE V limit_impulse(int i, V speed, V above, V below, Mask at_lower, Mask at_upper,
                                bool last) {
    const V mass = limit_mass[i];
    const V overlap_rate = simd::broadcast<V>(kOverlapShare * inv_dt);
    const V lower_goal = above < 0.0 ? (last ? speed : -above * overlap_rate) : -above * inv_dt;
    const V upper_goal = below < 0.0 ? (last ? speed : below * overlap_rate) : below * inv_dt;
    const V lower_pushed = simd::max(V{}, lower_impulse[i] + (lower_goal - speed) * mass);
    const V upper_pushed = simd::min(V{}, upper_impulse[i] + (upper_goal - speed) * mass);
    const V lower_released = lower_impulse[i] + simd::max(-speed * mass, -lower_impulse[i]);
    const V upper_released = upper_impulse[i] + simd::min(-speed * mass, -upper_impulse[i]);
    const auto opens = speed > 0.0;
    const V lower =
        at_lower ? lower_pushed
                 : (at_upper ? lower_impulse[i] : (opens ? lower_released : lower_impulse[i]));
    const V upper = at_lower
                        ? upper_impulse[i]
                        : (at_upper ? upper_pushed : (opens ? upper_impulse[i] : upper_released));
    const V change = (lower - lower_impulse[i]) + (upper - upper_impulse[i]);
    lower_impulse[i] = lower;
    upper_impulse[i] = upper;
    return change;
  }
};

}  // namespace ENGRAM_ISA
}  // namespace engram
