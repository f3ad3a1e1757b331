// The robot as its kernels know it: seven hinges in a row, each about its own z axis, and two
// fingers that slide along lines of the last link. Plain numbers.
#pragma once

#include "core/robot/joints.h"

namespace engram {

struct RobotModel {
  // A rigid body; what is fixed to it counts as part of it.
  struct Link {
    double offset[3] = {};   // m, origin in the frame of the link before, at joint angle zero
    double turn[9] = {};     // axes (columns) in the frame of the link before, at joint angle zero
    double mass = 0;         // kg
    double center[3] = {};   // m, centre of mass, own frame
    double inertia[6] = {};  // about the centre, own axes: xx, yy, zz, xy, xz, yz; kg m^2
  };
  // The first link's frame before is the world, shifted to the base.
  Link arm[kArmJoints];
  // Their turns are one: they never turn against the last link. `center` and `inertia` are in its
  // axes, too.
  Link finger[kFingers];
  double slide[kFingers][3] = {};  // direction of opening, in the last link's frame
  double base[3] = {};             // m, world

  // From the last link to the TCP.
  double tool_offset[3] = {};
  double tool_quat[4] = {};
  double quat[kArmJoints][4] = {};  // of the links' turns

  double arms[kRobotJoints] = {};  // most that a point of the robot moves per rad or m of a joint
};

}  // namespace engram
