// How the robot's nine joints move in one substep, for a single robot or for many side by side:
// drives, the coupling of the fingers and the joint limits are impulses, found one after the other,
// again and again. docs/physics.md says where this law comes from.
#pragma once

#include "core/math/lanes.h"
#include "core/robot/robot_params.h"

namespace engram {

inline namespace ENGRAM_LANES {

constexpr int kSolverIterations = 15;
constexpr double kLinkDamping = 0.05;       // 1/s, of the arm's turning
constexpr double kCouplingStiffness = 1e5;  // N/m, between the fingers

// Free rotation is integrated explicitly, in reach of no drive: wrist joints that spin faster than
// this would gain speed from it. rad/s, m/s; PhysX's limit as well.
constexpr double kFastestJoint = 100;

constexpr int kLeftFinger = kArmJoints;
constexpr int kRightFinger = kArmJoints + 1;

// Rows may be longer than the joints are many: a single robot's are whole vectors so, and have
// zeros at their ends.
template <class V>
constexpr int kJointRow = kLanesOf<V> == 1 ? kRobotJoints + 1 : kRobotJoints;
template <class V>
struct JointsOf {
  V at[kJointRow<V>] = {};
  V& operator[](int i) { return at[i]; }
  const V& operator[](int i) const { return at[i]; }
};

// row += scale * other
template <class V>
ENGRAM_LANES_INLINE void add_scaled(JointsOf<V>& row, V scale, const JointsOf<V>& other) {
  for (int i = 0; i < kJointRow<V>; ++i) row[i] += scale * other[i];
}

template <class V>
struct JointMatrixOf {
  JointsOf<V> row[kRobotJoints];
  JointsOf<V>& operator[](int i) { return row[i]; }
  const JointsOf<V>& operator[](int i) const { return row[i]; }
};

// Of a symmetric positive definite matrix. Gauss and Jordan; such matrices need no pivoting.
template <class V>
ENGRAM_LANES_INLINE void invert(JointMatrixOf<V>& m) {
  for (int k = 0; k < kRobotJoints; ++k) {
    const V pivot = 1.0 / m[k][k];
    m[k][k] = spread<V>(1);
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
  // --- what the substep begins with ---

  JointMatrixOf<V> w;                   // inertia; its inverse from prepare() on
  JointsOf<V> begin_v;                  // rad/s, m/s; after damping and bias from prepare() on
  JointsOf<V> bias;                     // Coriolis and centrifugal forces, N m, N
  JointsOf<V> aim;                      // stiffness target + damping target velocity
  double stiffness[kRobotJoints] = {};  // of each drive; none in velocity mode

  // --- what it ends with: end_q begins as q ---

  JointsOf<V> end_q;     // rad, m
  JointsOf<V> end_v;     // rad/s, m/s
  JointsOf<V> driven;    // impulses of this substep, added up: drives,
  JointsOf<V> at_lower;  // lower limits,
  JointsOf<V> at_upper;  // upper limits

  double hh;      // of one iteration, s
  double per_hh;  // 1 / hh
  JointsOf<V> gain;
  JointsOf<V> brake;
  JointsOf<V> resist;  // inverse of w's diagonal
  JointsOf<V> couple;  // change of velocities by a unit of the coupling's impulse
  V couple_gain;

  ENGRAM_LANES_INLINE void prepare(const RobotParams& law) {
    hh = law.timestep / kSolverIterations;
    per_hh = kSolverIterations / law.timestep;
    invert(w);
    for (int i = 0; i < kRobotJoints; ++i) {
      const double resistance = law.drive.damping + hh * stiffness[i];
      gain[i] = hh / (1.0 + w[i][i] * (hh * resistance));
      brake[i] = gain[i] * resistance;
      resist[i] = 1.0 / w[i][i];
      couple[i] = w[i][kLeftFinger] - w[i][kRightFinger];
      if (i < kArmJoints) begin_v[i] *= 1 - kLinkDamping * law.timestep;
    }
    const V give = couple[kLeftFinger] - couple[kRightFinger];
    const double unit = hh * kCouplingStiffness;
    couple_gain = unit / (1.0 + give * (hh * unit));
    for (int i = 0; i < kRobotJoints; ++i) add_scaled(begin_v, -law.timestep * bias[i], w[i]);
  }

  // `pushed`: what forces of contacts add to the velocities in one iteration; may be null.
  // `spent`, if not null: counts the iterations in which a drive is at its limit.
  ENGRAM_LANES_INLINE void run(const RobotParams& law, const JointsOf<V>* pushed,
                               JointsOf<V>* spent) {
    const double most = law.drive.limit * law.timestep;
    JointsOf<V> speed = begin_v;
    driven = at_lower = at_upper = {};
    bool limited = false;
    for (int iteration = 0; iteration < kSolverIterations; ++iteration) {
      if (pushed != nullptr) add_scaled(speed, spread<V>(1), *pushed);
      couple_fingers(speed);
      for (int i = 0; i < kRobotJoints; ++i) {
        const V pull = gain[i] * (aim[i] - stiffness[i] * end_q[i]);
        move_joint(law, most, i, pull, speed, spent, limited);
      }
      for (int i = 0; i < kRobotJoints; ++i) end_q[i] += hh * speed[i];
    }
    for (int i = 0; i < kRobotJoints; ++i) {
      end_v[i] = lesser(spread<V>(kFastestJoint), greater(spread<V>(-kFastestJoint), speed[i]));
    }
  }

  // An undamped spring, taken implicitly.
  ENGRAM_LANES_INLINE void couple_fingers(JointsOf<V>& speed) const {
    const V apart =
        end_q[kLeftFinger] - end_q[kRightFinger] + hh * (speed[kLeftFinger] - speed[kRightFinger]);
    add_scaled(speed, -couple_gain * apart, couple);
  }

  // The drive's impulse, and those of the limits: a joint goes no faster than to its limit.
  ENGRAM_LANES_INLINE void move_joint(const RobotParams& law, double most, int i, V pull,
                                      JointsOf<V>& speed, JointsOf<V>* spent, bool& limited) {
    const V wanted = driven[i] + (pull - brake[i] * speed[i]);
    const V sum = lesser(spread<V>(most), greater(spread<V>(-most), wanted));
    if (spent != nullptr) (*spent)[i] += magnitude(wanted) >= most ? spread<V>(1) : V{};
    add_scaled(speed, sum - driven[i], w[i]);
    driven[i] = sum;
    const V to_lower = (law.lower[i] - end_q[i]) * per_hh;
    const V to_upper = (law.upper[i] - end_q[i]) * per_hh;
    // Whether to look depends on all lanes; what is found, on each lane alone.
    if (limited || any(either(speed[i]<to_lower, speed[i]> to_upper))) [[unlikely]] {
      limited = true;
      push(greater(V{}, at_lower[i] + (to_lower - speed[i]) * resist[i]), i, at_lower[i], speed);
      push(lesser(V{}, at_upper[i] + (to_upper - speed[i]) * resist[i]), i, at_upper[i], speed);
    }
  }

  // A limit pushes one way only.
  ENGRAM_LANES_INLINE void push(V impulse, int i, V& before, JointsOf<V>& speed) const {
    const V more = impulse - before;
    const auto pushes = more != V{};
    for (int k = 0; k < kJointRow<V>; ++k) {
      // Adding nothing would change the sign of a zero.
      speed[k] = pushes ? speed[k] + more * w[i][k] : speed[k];
    }
    before = impulse;
  }
};

}  // namespace ENGRAM_LANES
}  // namespace engram
