// One substep of one robot's nine joints, by JointSolver. Contacts come in as forces.
#pragma once

#include "core/robot/joint_solver.h"
#include "core/robot/robot_model.h"

namespace engram {

using JointRow = JointsOf<double>;
using JointMatrix = JointMatrixOf<double>;

// stiffness * target + damping * target velocity: the part of a drive's force that does not depend
// on the joint's motion, N m, N.
double drive_bias(const RobotParams& params, const DriveTarget& target, int joint);

class RobotStep {
 public:
  RobotStep(const RobotParams& params, const DriveTarget& target);

  // --- state at the substep's beginning ---

  JointArray q{};           // rad, m
  JointArray v{};           // rad/s, m/s
  JointMatrix mass_matrix;  // of the links alone; kg m^2, kg m, kg
  JointArray bias_force{};  // Coriolis and centrifugal forces, N m, N

  // Reads a lane of a block's memory, after a substep with details: its beginning, and its end as
  // long as nothing touches the robot.
  void load(const double* rows, int lanes, int lane);
  // Computes it from joint positions and velocities alone.
  void begin(const RobotModel& robot, const double* qpos, const double* qvel);

  // Computes the substep: `force` acts all through it, N m, N.
  void run(const JointArray& force);
  // Replaces the result of run(): the whole substep at its last velocity, as free props move, so
  // that nothing slips along the robot whenever it speeds up. No joint gets further beyond its
  // limits.
  void integrate_constant_velocity(const JointArray& velocity);

  double force_limit() const { return params_.drive.limit; }  // of a drive, N m, N

  // --- after load() or run() ---

  const JointArray& end_q() const { return end_q_; }
  const JointArray& end_v() const { return end_v_; }
  // After run(). The mass matrix that a contact's force f meets: it changes the velocity at the
  // substep's end by timestep inverse(matrix) f. Drives oppose it, unless they are at their
  // limits; joints at their limits do not move.
  JointMatrix effective_mass_matrix() const;

 private:
  void prepare();

  const RobotParams& params_;
  JointSolver<double> joints_;
  bool prepared_ = false;

  JointArray end_q_{};
  JointArray end_v_{};
  JointArray force_{};          // of contacts, in the last run
  JointsOf<double> saturated_;  // iterations in which a drive is at its limit
};

}  // namespace engram
