// One substep of one robot's nine joints, by the law of joint_law.h. Contacts come in as forces.
#pragma once

#include <array>

#include "core/robot/drive.h"
#include "core/robot/joint_solver.h"
#include "core/robot/robot_model.h"

namespace engram {

// Rows of nine, and a tenth element that is always zero: whole vectors for the compiler.
using JointRow = std::array<double, kRobotJoints + 1>;
using JointMatrix = std::array<JointRow, kRobotJoints>;

// Of a symmetric positive definite matrix.
JointMatrix inverse(JointMatrix matrix);

// What a joint's drive follows, as the law takes it: see JointSolver.
double drive_stiffness(const RobotParams& law, const Drive& drive, int joint);
double drive_aim(const RobotParams& law, const Drive& drive, int joint);

class RobotStep {
 public:
  RobotStep(const RobotParams& law, const Drive& drive);

  // --- what a substep begins with ---

  JointArray q{};         // rad, m
  JointArray v{};         // rad/s, m/s
  JointMatrix inertia{};  // of the links alone; kg m^2, kg m, kg
  JointArray bias{};      // Coriolis and centrifugal forces, N m, N

  // From a lane of a block's memory, after a substep with details: its start, and its end as long
  // as nothing touches the robot.
  void take(const double* rows, int lanes, int lane);
  // From joint positions and velocities alone.
  void begin(const RobotModel& chain, const double* qpos, const double* qvel);

  // Computes the substep: `force` acts all through it, N m, N.
  void run(const JointArray& force);
  // Instead of what run() found: the whole substep at its last velocity, as free props move, so
  // that nothing slips along the robot whenever it speeds up. No joint gets further beyond its
  // limits.
  void move_evenly(const JointArray& velocity);

  double force_limit() const { return law_.drive.limit; }  // of a drive, N m, N

  // --- after take() or run() ---

  const JointArray& end_q() const { return end_q_; }
  const JointArray& end_v() const { return end_v_; }
  // After run(). The inertia that a contact's force f meets: it changes the velocity at the
  // substep's end by timestep inverse(inertia) f. Drives resist it, unless they are at their
  // limits; joints at their limits do not give way.
  JointMatrix effective_inertia() const;

 private:
  void prepare();

  const RobotParams& law_;
  JointSolver<double> joints_;
  bool prepared_ = false;

  JointArray end_q_{};
  JointArray end_v_{};
  JointArray force_{};      // of contacts, in the last run
  JointsOf<double> spent_;  // iterations in which a drive is at its limit
};

}  // namespace engram
