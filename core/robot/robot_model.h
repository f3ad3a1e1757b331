// The robot: seven hinges in a row, each about its own z axis, and two fingers that slide along
// lines of the last link; what their drives follow, and the constants of all. Plain numbers.
#pragma once

#include <array>
#include <bit>
#include <cstddef>

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

// Rounds all numbers of a structure that consists of doubles.
template <template <class> class Struct>
Struct<float> rounded(const Struct<double>& exact) {
  constexpr std::size_t kNumbers = sizeof(Struct<double>) / sizeof(double);
  const auto from = std::bit_cast<std::array<double, kNumbers>>(exact);
  std::array<float, kNumbers> to;
  for (std::size_t i = 0; i < kNumbers; ++i) to[i] = static_cast<float>(from[i]);
  return std::bit_cast<Struct<float>>(to);
}

// force = stiffness (target - q) + damping (target velocity - qvel), within the limit. Taken
// implicitly.
template <class Scalar>
struct DriveParamsOf {
  Scalar stiffness = 0;  // N m/rad, N/m
  Scalar damping = 0;    // N m s/rad, N s/m
  Scalar limit = 0;      // N m, N
};
using DriveParams = DriveParamsOf<double>;

// Constants of all substeps.
template <class Scalar>
struct RobotParamsOf {
  DriveParamsOf<Scalar> drive;
  Scalar lower[kRobotJoints] = {};  // joint limits, rad, m
  Scalar upper[kRobotJoints] = {};  // rad, m
  Scalar timestep = 0;              // of a substep, s
};
// What the solver has in single precision, it has of `single`.
struct RobotParams : RobotParamsOf<double> {
  RobotParamsOf<float> single;  // rounded, once all else is set
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

template <class Scalar>
struct RobotModelOf {
  // A rigid body with all that is fixed to it.
  struct Link {
    Scalar offset[3] = {};    // m, origin in the parent link's frame, at joint angle zero
    Scalar rotation[9] = {};  // axes (columns) in the parent link's frame, at joint angle zero
    Scalar mass = 0;          // kg
    Scalar center[3] = {};    // m, centre of mass, own frame
    Scalar inertia[6] = {};   // about the centre, own axes: xx, yy, zz, xy, xz, yz; kg m^2
  };
  // The first link's parent frame is the world, shifted to the base.
  Link links[kArmJoints];
  Scalar link_quat[kArmJoints][4] = {};  // of the links' rotations
  // Fingers never rotate against the last link. Their `center` and `inertia` are in its axes, too.
  Link fingers[kFingers];
  Scalar finger_axis[kFingers][3] = {};  // direction of opening, in the last link's frame
  Scalar base_position[3] = {};          // m, world
  // Centres of mass of the rigid bodies, m: in the frame of the arm's link that carries them, the
  // fingers closed.
  Scalar centers[kNumLinks][3] = {};

  // Pose of the TCP in the last link's frame.
  Scalar tcp_offset[3] = {};
  Scalar tcp_quat[4] = {};

  // The greatest displacement of any point of the robot per rad or m of a joint.
  Scalar lever_arms[kRobotJoints] = {};
};
struct RobotModel : RobotModelOf<double> {
  RobotModelOf<float> single;  // rounded, for the kernels, once all else is set
};

}  // namespace engram
