// One substep of the robot's nine joints, the original's way: drives, the coupling of the fingers
// and the joint limits are impulses, found one after the other, again and again. Contacts come in
// as forces. docs/physics.md says where this law comes from.
#pragma once

#include <array>

#include "core/physics/drive.h"

namespace engram {

// Rows of nine, and a tenth element that is always zero: whole vectors for the compiler.
using JointRow = std::array<double, kRobotJoints + 1>;
using JointMatrix = std::array<JointRow, kRobotJoints>;

// Of a symmetric positive definite matrix.
JointMatrix inverse(JointMatrix matrix);

class RobotStep {
 public:
  // What is the same in every substep.
  struct Law {
    DriveLaw drive;
    JointArray lower{};   // joint limits, rad, m
    JointArray upper{};   // rad, m
    double timestep = 0;  // of a substep, s
  };

  RobotStep(const Law& law, const Drive& drive);

  // --- what a substep begins with ---

  JointArray q{};         // rad, m
  JointArray v{};         // rad/s, m/s
  JointMatrix inertia{};  // of the links alone; kg m^2, kg m, kg
  JointArray bias{};      // Coriolis and centrifugal forces, N m, N

  // Computes the substep: `force` acts all through it, N m, N. Reads, but does not change, what the
  // substep begins with.
  void prepare();
  void run(const JointArray& force);
  // Instead of what run() found: the whole substep at its last velocity, as free props move, so
  // that nothing slips along the robot whenever it speeds up. No joint gets further beyond its
  // limits.
  void move_evenly(const JointArray& velocity);

  double force_limit() const { return law_.drive.limit; }  // of a drive, N m, N

  // --- after run() ---

  const JointArray& end_q() const { return end_q_; }
  const JointArray& end_v() const { return end_v_; }
  // The inertia that a contact's force f meets: it changes the velocity at the substep's end by
  // timestep inverse(inertia) f. Drives resist it, unless they are at their limits; joints at their
  // limits do not give way.
  JointMatrix effective_inertia() const;

 private:
  void couple_fingers(JointRow& speed) const;
  void move_joint(std::size_t joint, JointRow& speed);
  void stop_at_limits(std::size_t joint, JointRow& speed);

  const Law& law_;
  double hh_;              // of one iteration, s
  double most_;            // impulse of a drive in a substep, N m s, N s
  JointArray stiffness_;   // of each joint; none in velocity mode
  JointArray aim_;         // stiffness target + damping target velocity
  JointArray resistance_;  // impulse per velocity, before gain

  JointMatrix w_{};    // inverse of the inertia
  JointRow couple_{};  // change of velocities by a unit of the coupling's impulse
  double couple_gain_ = 0;
  JointArray gain_{};
  JointArray brake_{};
  JointArray pull_{};   // impulses of the drives of joints that stand still
  JointRow begin_v_{};  // after damping and bias

  JointArray end_q_{};
  JointArray end_v_{};
  JointArray force_{};     // of contacts, in the last run
  JointArray driven_{};    // impulses of this substep, added up: drives,
  JointArray spent_{};     // part of the substep in which a drive is at its limit
  JointArray at_lower_{};  // lower limits,
  JointArray at_upper_{};  // upper limits
};

}  // namespace engram
