// The robot: seven hinges in a row, each about its own z axis, and two fingers that slide along
// lines of the last link; what their drives follow, and the constants of all. Plain numbers.
#pragma once

#include <array>

namespace engram {

inline constexpr int kArmJoints = 7;
inline constexpr int kFingers = 2;
inline constexpr int kRobotJoints = kArmJoints + kFingers;  // qpos order: arm, left, right finger

using JointArray = std::array<double, kRobotJoints>;

// Targets of the nine drives during one control step.
struct DriveTarget {
  JointArray qpos{};                      // rad, m
  std::array<double, kArmJoints> qvel{};  // rad/s, added through the damping
  bool velocity_mode = false;             // arm: no stiffness, velocity target only
};

// force = stiffness (target - q) + damping (target velocity - qvel), within the limit. Taken
// implicitly.
struct DriveParams {
  double stiffness = 0;  // N m/rad, N/m
  double damping = 0;    // N m s/rad, N s/m
  double limit = 0;      // N m, N
};

// Constants of all substeps.
struct RobotParams {
  DriveParams drive;
  double lower[kRobotJoints] = {};  // joint limits, rad, m
  double upper[kRobotJoints] = {};  // rad, m
  double timestep = 0;              // of a substep, s
};

// Rigid bodies of the robot, each with a centre of mass of its own: the arm's links, then these.
inline constexpr int kLeftFingerLink = kArmJoints;
inline constexpr int kRightFingerLink = kArmJoints + 1;
inline constexpr int kHandLink = kArmJoints + 2;
inline constexpr int kCameraLink = kArmJoints + 3;
inline constexpr int kNumLinks = kArmJoints + 4;

// Number of hinges that move a link.
constexpr int hinges_of(int link) { return link < kArmJoints ? link + 1 : kArmJoints; }
// The finger that a link is, or -1.
constexpr int finger_of(int link) {
  return link == kLeftFingerLink || link == kRightFingerLink ? link - kArmJoints : -1;
}

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
  // Centres of mass of the rigid bodies, m: in the frame of the arm's link that carries them, the
  // fingers closed.
  double centers[kNumLinks][3] = {};

  // Pose of the TCP in the last link's frame.
  double tcp_offset[3] = {};
  double tcp_quat[4] = {};

  // The greatest displacement of any point of the robot per rad or m of a joint.
  double lever_arms[kRobotJoints] = {};
};

}  // namespace engram
