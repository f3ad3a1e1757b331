// Many robots side by side, one in each lane of the processor's vectors: what every substep and
// every control step compute for all of them, whatever their scenes are.
#pragma once

#include "core/robot/robot_model.h"
#include "core/robot/robot_params.h"

namespace engram {

// Where a quantity's rows begin in the memory of a block. A row has one double for each lane.
struct LaneRows {
  static constexpr int kQ = 0;                        // (9) rad, m: joint positions
  static constexpr int kV = kQ + kRobotJoints;        // (9) rad/s, m/s
  static constexpr int kAim = kV + kRobotJoints;      // (9) see JointSolver
  static constexpr int kEndQ = kAim + kRobotJoints;   // (9) after the substep, if nothing touches
  static constexpr int kEndV = kEndQ + kRobotJoints;  // (9)
  static constexpr int kSeen = kEndV + kRobotJoints;  // (9) where the clearance was found
  static constexpr int kRoom = kSeen + kRobotJoints;  // (1) m, what it was
  // Written on demand.
  static constexpr int kBias = kRoom + 1;                                // (9)
  static constexpr int kInertia = kBias + kRobotJoints;                  // (9 x 9)
  static constexpr int kLinks = kInertia + kRobotJoints * kRobotJoints;  // (7 x (3 + 9))
  // Of reach().
  static constexpr int kTwist = kLinks + kArmJoints * 12;  // (6) wanted step of the TCP, m, rad
  static constexpr int kStep = kTwist + 6;                 // (7) of the joints, rad
  static constexpr int kJacobian = kStep + kArmJoints;     // (6 x 7), column by column
  static constexpr int kTcp = kJacobian + 6 * kArmJoints;  // (3 + 4) pose
  static constexpr int kCount = kTcp + 7;
};

struct LaneKernel {
  const char* name;  // of the instruction set
  int lanes;

  // The lanes, as bits, whose robots may have come nearer to something than they had room. Needs
  // kQ, kSeen, kRoom.
  unsigned (*moved_far)(const RobotModel& chain, const double* rows);
  // One substep, as if nothing touched: kQ, kV, kAim to kEndQ, kEndV. `details`: writes kBias,
  // kInertia and kLinks as well.
  void (*substep)(const RobotModel& chain, const RobotParams& law, bool velocity_mode, double* rows,
                  bool details);
  // kQ to kTcp.
  void (*tool)(const RobotModel& chain, double* rows);
  // kQ and kTwist to kStep, the smallest joint step that realises the twist, and kJacobian. Returns
  // the lanes, as bits, in which the Jacobian is too near to losing a rank: there, kStep is not
  // valid.
  unsigned (*reach)(const RobotModel& chain, double* rows);
};

inline constexpr int kMostLanes = 8;

// The kernel of so many lanes (1, 2, 4, 8), or null if this processor has none.
const LaneKernel* lane_kernel(int lanes);
// The widest that the processor has.
const LaneKernel& widest_lane_kernel();

}  // namespace engram
