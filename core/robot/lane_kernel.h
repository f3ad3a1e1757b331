// Many robots side by side, one in each lane of the processor's vectors: what every substep and
// every control step compute for all of them, whatever their scenes are.
#pragma once

#include "core/math/instruction_set.h"
#include "core/robot/robot_model.h"

namespace engram {

// First rows of quantities in the memory of a block. A row has one double for each lane;
// kernels compute in single precision.
struct LaneVectors {
  static constexpr int kQ = 0;                                 // (9) rad, m: joint positions
  static constexpr int kV = kQ + kRobotJoints;                 // (9) rad/s, m/s
  static constexpr int kDriveBias = kV + kRobotJoints;         // (9) see JointSolver
  static constexpr int kEndQ = kDriveBias + kRobotJoints;      // (9) after a substep
  static constexpr int kEndV = kEndQ + kRobotJoints;           // (9)
  static constexpr int kClearanceQpos = kEndV + kRobotJoints;  // (9) where it was measured
  static constexpr int kSelfClearance = kClearanceQpos + kRobotJoints;  // (9) m, see RobotBounds
  static constexpr int kClearance = kSelfClearance + kRobotJoints;      // (1) m, to all else
  static constexpr int kLinkPoses = kClearance + 1;  // (7 x (3 + 9)) written on demand
  // Rows of differential_ik() and forward_kinematics().
  static constexpr int kDisplacement = kLinkPoses + kArmJoints * 12;  // (6) of the TCP, m, rad
  static constexpr int kStep = kDisplacement + 6;                     // (7) of the joints, rad
  static constexpr int kJacobian = kStep + kArmJoints;                // (6 x 7), column by column
  static constexpr int kTcp = kJacobian + 6 * kArmJoints;             // (3 + 4) pose
  static constexpr int kCount = kTcp + 7;
};

struct LaneKernel {
  InstructionSet instruction_set;
  int lanes;

  // The lanes, as bits, whose robots may have moved farther than a clearance, or than that to all
  // else after `look_ahead` seconds at their velocity, of which `allowance` metres do not count.
  // Reads kQ, kV, kClearanceQpos, kSelfClearance, kClearance.
  unsigned (*clearance_exceeded)(const RobotModel& robot, double look_ahead, double allowance,
                                 const double* vectors);
  // kQ to kLinkPoses.
  void (*pose_links)(const RobotModel& robot, double* vectors);
  // One substep without contacts: kQ, kV, kDriveBias to kEndQ, kEndV.
  void (*substep)(const RobotModel& robot, const RobotParams& params, bool velocity_mode,
                  double* vectors);
  // kQ to kTcp.
  void (*forward_kinematics)(const RobotModel& robot, double* vectors);
  // kQ and kDisplacement to kStep, the smallest joint step that gives the displacement, and
  // kJacobian. Returns the lanes, as bits, in which the Jacobian is too near to losing a rank:
  // there, kStep is not valid.
  unsigned (*differential_ik)(const RobotModel& robot, double* vectors);
};

inline constexpr int kMaxLanes = 16;

// The kernel of N lanes (1, 4, 8, 16), or null if this processor or build has none.
const LaneKernel* lane_kernel(int lanes);
// The widest that the processor has, and the widest of which N robots fill at least half.
const LaneKernel& widest_lane_kernel();
const LaneKernel& lane_kernel_for(int robots);

// Kernels of wide instruction sets, and of one lane, whether the processor has them or
// not; null where this library was built without them.
const LaneKernel* avx2_lane_kernel();
const LaneKernel* avx512_lane_kernel();
const LaneKernel& baseline_single_kernel();
const LaneKernel* avx2_single_kernel();

}  // namespace engram
