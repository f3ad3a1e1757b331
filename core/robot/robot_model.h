// Kinematic and inertial constants of the robot: seven hinges in a row, each about its own z axis,
// and two fingers that slide along lines of the last link. Plain numbers.
#pragma once

#include "core/robot/robot_params.h"

namespace engram {

struct RobotModel {
  // A rigid body with all that is fixed to it.
  struct Link {
    double offset[3] = {};    // m, origin in the parent link's frame, at joint angle zero
    double rotation[9] = {};  // axes (columns) in the parent link's frame, at joint angle zero
    double mass = 0;          // kg
    double center[3] = {};    // m, centre of mass, own frame
    double inertia[6] = {};   // about the centre, own axes: xx, yy, zz, xy, xz, yz; kg m^2
  };
  // The first link's parent frame is the world, shifted to the base.
  Link links[kArmJoints];
  double link_quat[kArmJoints][4] = {};  // of the links' rotations
  // Fingers never rotate against the last link. Their `center` and `inertia` are in its axes, too.
  Link fingers[kFingers];
  double finger_axis[kFingers][3] = {};  // direction of opening, in the last link's frame
  double base_position[3] = {};          // m, world

  // Pose of the TCP in the last link's frame.
  double tcp_offset[3] = {};
  double tcp_quat[4] = {};

  // The greatest displacement of any point of the robot per rad or m of a joint.
  double lever_arms[kRobotJoints] = {};
};

}  // namespace engram
