// One substep of environments side by side in which something touches.
#pragma once

#include "core/collision/broad_phase_lanes.h"
#include "core/contact/contact_lanes.h"
#include "core/robot/lane_kernel.h"

namespace engram {

struct ContactKernel {
  int lanes;
  // kLinkPoses and kV to frames, centres and speeds of the robot.
  void (*pose_robot)(const RobotModel& robot, const double* vectors, const BroadPhaseLanes& lanes);
  // All bodies' frames and speeds to their travel and the pairs of shapes near each other.
  void (*find_near)(BroadPhaseLanes& lanes);
  // As LaneKernel::substep, with contacts: moves the free bodies as well, and sets the impulses of
  // patches and which of them slip.
  void (*substep)(const RobotModel& robot, const RobotParams& params, bool velocity_mode,
                  double* vectors, const ContactLanes& contacts);
};

// The kernel of N lanes, of those that lane_kernel() has.
const ContactKernel& contact_kernel(int lanes);

const ContactKernel& baseline_single_contact_kernel();
// Null where this library was built without the instruction set.
const ContactKernel* avx2_contact_kernel();
const ContactKernel* avx2_single_contact_kernel();
const ContactKernel* avx512_contact_kernel();

}  // namespace engram
