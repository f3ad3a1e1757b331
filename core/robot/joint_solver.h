// One substep of the robot's nine joints, for a single robot or for many side by side: projected
// Gauss-Seidel over contacts, the fingers' tendon, implicit drives and joint limits, with positions
// advanced in every iteration (PhysX's temporal Gauss-Seidel). docs/physics.md has the whole law.
//
// W is the inverse of the mass matrix, c the bias forces (Coriolis, centrifugal), h the substep,
// dt = h / kSolverIterations. Velocities without contacts:
//
//   v = v (1 - kLinkDamping h) for the arm;   v = v - h W c
//
// Each iteration, in this order; an impulse p on joint i changes all velocities, v += W_i p:
//
//   tendon    u = (q_L - q_R + dt (v_L - v_R)) / 2
//             p = -+ dt k u / (1 + dt^2 k W_ii), for both fingers from one u
//   drive i   r = damping + dt stiffness;   g = dt / (1 + W_ii dt r)
//             f = f + g (bias - stiffness q - r v), within +- max_force h
//   limit i   f = f + (goal - v) / (W_ii + s), of one sign;   goal = -gap / dt, or beta overlap /
//   dt q = q + dt v, fingers clamped to their limits
//
// A last iteration solves velocities alone: overlaps count as 0, drives do nothing.
//
// In single precision, iterations move the displacement D from where the substep begins, which is a
// small number; what holds q itself, such as bias - stiffness q, is formed in double before they
// begin.
#pragma once

#include "core/robot/joint_rows.h"

namespace engram {
inline namespace ENGRAM_ISA {

constexpr int kSolverIterations = 15;
constexpr float kLinkDamping = 0.05F;     // 1/s, of the arm's joint velocities
constexpr float kTendonStiffness = 1e5F;  // N/m, between the fingers
// beta, the share of an overlap that one iteration takes out: 2 sqrt(1 / kSolverIterations).
constexpr float kBaumgarte = 0.51639778F;

// Limit of joint velocities, rad/s, m/s; PhysX's as well. Free rotation is integrated explicitly,
// and wrist joints beyond it would gain energy.
constexpr float kMaxJointVelocity = 100;

constexpr int kLeftFinger = kArmJoints;
constexpr int kRightFinger = kArmJoints + 1;

// Stiffness of a joint's drive, N m/rad, N/m: none for the arm in velocity mode.
template <class Scalar>
ENGRAM_INLINE Scalar drive_stiffness(const RobotParamsOf<Scalar>& params, bool velocity_mode,
                                     int joint) {
  return velocity_mode && joint < kArmJoints ? Scalar{} : params.drive.stiffness;
}

// Contacts of a robot that touches nothing.
template <class V>
struct NoContacts {
  // Pairs of a moving body with a link or another moving body, then of moving bodies with fixed
  // ones. `last`: the velocity iteration.
  ENGRAM_INLINE void solve_bodies(WideRow<V>& /*velocity*/, bool /*last*/) {}
  ENGRAM_INLINE void move_bodies() {}
  // Contacts with fixed bodies of the links that move with a joint and no later one. False if there
  // are none.
  ENGRAM_INLINE bool solve_links(int /*joint*/, WideRow<V>& /*velocity*/, bool /*last*/) {
    return false;
  }
  ENGRAM_INLINE void move_links(const WideRow<V>& /*displacement*/) {}
};

// V: float or simd::Float.
template <class V>
struct JointSolver {
  using Params = RobotParamsOf<float>;

  // --- input of prepare() ---

  JointMatrixOf<V> inv_mass;  // mass matrix; prepare() inverts it
  JointsOf<V> begin_v;        // rad/s, m/s; after damping and bias from prepare() on
  JointsOf<V> bias_force;     // Coriolis and centrifugal forces, N m, N
  // stiffness * (target - q) + damping * target velocity, at the substep's start
  JointsOf<V> drive_bias;
  float stiffness[kRobotJoints] = {};  // of each drive
  JointsOf<V> above, below;            // distances from the joint limits at the start, rad, m
  V fingers_apart;                     // left less right at the start, m

  // --- output of run() ---

  JointsOf<V> displacement;  // since the start, rad, m
  JointsOf<V> end_v;         // rad/s, m/s
  // Accumulated impulses of the substep.
  JointsOf<V> drive_impulse;
  JointsOf<V> lower_impulse;  // of joint limits
  JointsOf<V> upper_impulse;

  float dt;      // of one iteration, s
  float inv_dt;  // 1 / dt
  JointsOf<V> drive_gain;
  JointsOf<V> implicit_damping;
  JointsOf<V> tendon_response;  // change of velocities by a unit of the tendon's error

  // Limits of joints are compliant; known once a joint comes to its limit. From then on they are
  // solved wherever the joint is: the margin is 0 before and kUnlimited after.
  static constexpr float kUnlimited = 1e30F;
  JointsOf<V> limit_mass;
  float limit_margin[kRobotJoints] = {};  // rad, m

  ENGRAM_INLINE void prepare(const Params& params) {
    dt = params.timestep / kSolverIterations;
    inv_dt = kSolverIterations / params.timestep;
    invert(inv_mass);
    for (int i = 0; i < kRobotJoints; ++i) {
      const float resistance = params.drive.damping + dt * stiffness[i];
      drive_gain[i] = dt / (1.0F + inv_mass[i][i] * (dt * resistance));
      implicit_damping[i] = drive_gain[i] * resistance;
      if (i < kArmJoints) begin_v[i] *= 1 - kLinkDamping * params.timestep;
    }
    const float unit = dt * kTendonStiffness;
    const V left = unit / (1.0F + dt * unit * inv_mass[kLeftFinger][kLeftFinger]);
    const V right = unit / (1.0F + dt * unit * inv_mass[kRightFinger][kRightFinger]);
    for (int i = 0; i < kPadded<V, kRobotJoints>; ++i) {
      tendon_response[i] = right * inv_mass[kRightFinger][i] - left * inv_mass[kLeftFinger][i];
    }
    for (int i = 0; i < kRobotJoints; ++i) {
      add_scaled(begin_v, -params.timestep * bias_force[i], inv_mass[i]);
    }
    // No velocity is a negative zero, so that adding a zero impulse never changes a bit.
    for (int i = 0; i < kPadded<V, kRobotJoints>; ++i) begin_v[i] += V{};
  }

  // `frames`: LinkFrames at the substep's start, for the compliance of limits.
  template <class Frames, class Contacts>
  ENGRAM_INLINE void run(const Params& params, const Frames& frames, Contacts& contacts) {
    const float max_impulse = params.drive.limit * params.timestep;
    WideRow<V> velocity(begin_v);
    displacement = drive_impulse = lower_impulse = upper_impulse = {};
    WideRow<V> d(displacement);
    for (float& margin : limit_margin) margin = 0;
    for (int iteration = 0; iteration < kSolverIterations; ++iteration) {
      contacts.solve_bodies(velocity, false);
      contacts.move_bodies();
      solve_tendon(d, velocity);
      V next = velocity.template entry<0>();
      for_each_joint([&](auto joint) ENGRAM_INLINE_LAMBDA {
        solve_drive(max_impulse, joint, d, velocity, next);
        solve_joint_contacts(frames, contacts, joint, d, velocity, next, false);
      });
      integrate(d, velocity);
      contacts.move_links(d);
    }
    // The velocity iteration: overlaps push no more, and nothing moves.
    contacts.solve_bodies(velocity, true);
    solve_tendon(d, velocity);
    V next = velocity.template entry<0>();
    for_each_joint([&](auto joint) ENGRAM_INLINE_LAMBDA {
      solve_joint_contacts(frames, contacts, joint, d, velocity, next, true);
    });
    d.store(displacement);
    limit_velocity(velocity);
    velocity.store(end_v);
  }

  // Within the iterations as well: what throws the arm would go on to grow in them.
  ENGRAM_INLINE static void limit_velocity(WideRow<V>& velocity) {
    WideOf<V> fastest = simd::abs(velocity.at[0]);
    for_each_index<WideRow<V>::kVectors, 1>([&](auto i) ENGRAM_INLINE_LAMBDA {
      fastest = simd::max(fastest, simd::abs(velocity.at[i]));
    });
    if (!simd::any(fastest > kMaxJointVelocity)) [[likely]]
      return;
    for (WideOf<V>& speed : velocity.at)
      speed = simd::clamp(speed, -kMaxJointVelocity, kMaxJointVelocity);
  }

  // Fingers stop at their limits; joints of the arm do not.
  ENGRAM_INLINE void integrate(WideRow<V>& d, WideRow<V>& velocity) const {
    limit_velocity(velocity);
    d.add_scaled(simd::broadcast<V>(dt), velocity);
    for_each_index<kRobotJoints, kArmJoints>([&](auto i) ENGRAM_INLINE_LAMBDA {
      d.template set<i>(simd::min(below[i], simd::max(-above[i], d.template entry<i>())));
    });
  }

  // An undamped spring on the mean of both fingers' errors, taken implicitly for each finger alone.
  ENGRAM_INLINE void solve_tendon(const WideRow<V>& d, WideRow<V>& velocity) const {
    const V apart =
        fingers_apart + (d.template entry<kLeftFinger>() - d.template entry<kRightFinger>());
    const V speed =
        velocity.template entry<kLeftFinger>() - velocity.template entry<kRightFinger>();
    velocity.add_scaled(0.5F * (apart + dt * speed), WideRow<V>(tendon_response));
  }

  template <int kJoint>
  static constexpr int kNext = kJoint + 1 < kRobotJoints ? kJoint + 1 : 0;

  // Applies an impulse to a joint. Joints are solved in order, and each waits for the velocity that
  // the one before leaves it: `next`, which is computed apart, since to take it out of the row is
  // slow where a row is vectors.
  template <int kJoint>
  ENGRAM_INLINE void push(V impulse, WideRow<V>& velocity, V& next) const {
    const JointsOf<V>& response = inv_mass[kJoint];
    next = velocity.template entry<kNext<kJoint>>() + impulse * response[kNext<kJoint>];
    velocity.add_scaled(impulse, WideRow<V>(response));
  }

  // Short is the way from a velocity to the next one's: the limit of the drive is a branch, and the
  // change does not wait for the sum.
  template <int kJoint>
  ENGRAM_INLINE void solve_drive(float max_impulse, Index<kJoint> i, const WideRow<V>& d,
                                 WideRow<V>& velocity, V& next) {
    const V target_impulse =
        drive_gain[i] * (drive_bias[i] - stiffness[i] * d.template entry<kJoint>());
    const V before = drive_impulse[i];
    V change = target_impulse - implicit_damping[i] * next;
    V impulse = before + change;
    if (simd::any(simd::abs(impulse) > max_impulse)) [[unlikely]] {
      const V limited = simd::clamp(impulse, -max_impulse, max_impulse);
      change = impulse == limited ? change : limited - before;
      impulse = limited;
    }
    push<kJoint>(change, velocity, next);
    drive_impulse[i] = impulse;
  }

  // A joint goes no faster than to its limit, and links that move with it touch fixed bodies. All
  // lanes together decide whether limits are solved; the result is each lane's own.
  template <int kJoint, class Frames, class Contacts>
  ENGRAM_INLINE void solve_joint_contacts(const Frames& frames, Contacts& contacts, Index<kJoint> i,
                                          const WideRow<V>& d, WideRow<V>& velocity, V& next,
                                          bool last) {
    const V to_lower = above[i] + d.template entry<kJoint>();
    const V to_upper = below[i] - d.template entry<kJoint>();
    const V speed = velocity.template entry<kJoint>();
    const V margin = simd::min(to_lower, to_upper) - limit_margin[i];
    if (simd::any(margin < simd::abs(dt * speed))) [[unlikely]] {
      push<kJoint>(limit_impulse(frames, i, speed, to_lower, to_upper, last), velocity, next);
    }
    if (contacts.solve_links(i, velocity, last)) next = velocity.template entry<kNext<kJoint>>();
  }

  // Change of the impulse of a joint's limits. A limit that the joint leaves lets go of it.
  template <class Frames>
  [[gnu::noinline]] V limit_impulse(const Frames& frames, int i, V speed, V to_lower, V to_upper,
                                    bool last) {
    const V step = dt * speed;
    const auto at_lower = simd::logical_or(to_lower < 0.0F, to_lower + step < 0.0F);
    const auto at_upper = simd::logical_or(to_upper < 0.0F, to_upper - step < 0.0F);
    if (limit_margin[i] == 0) {
      if (!simd::any(simd::logical_or(at_lower, at_upper))) return V{};
      limit_margin[i] = kUnlimited;
      limit_mass[i] = 1.0F / (inv_mass[i][i] + frames.joint_compliance(i, inv_mass));
    }
    const V mass = limit_mass[i];
    const V bias_rate = simd::broadcast<V>(kBaumgarte * inv_dt);
    const V lower_goal =
        to_lower < 0.0F ? (last ? speed : -to_lower * bias_rate) : -to_lower * inv_dt;
    const V upper_goal =
        to_upper < 0.0F ? (last ? speed : to_upper * bias_rate) : to_upper * inv_dt;
    const V lower_pushed = simd::max(V{}, lower_impulse[i] + (lower_goal - speed) * mass);
    const V upper_pushed = simd::min(V{}, upper_impulse[i] + (upper_goal - speed) * mass);
    const V lower_released = lower_impulse[i] + simd::max(-speed * mass, -lower_impulse[i]);
    const V upper_released = upper_impulse[i] + simd::min(-speed * mass, -upper_impulse[i]);
    const auto opens = speed > 0.0F;
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
