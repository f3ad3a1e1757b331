// Numbers of the Franka Panda with its wrist camera: names, frames, inertia, joints. See
// docs/robot.md.
#pragma once

#include <array>
#include <span>

#include "mjcf/prop.h"

namespace engram::mjcf {

// The bodies in the order of their MuJoCo ids (after the world).
enum class Link {
  kLink0,
  kLink1,
  kLink2,
  kLink3,
  kLink4,
  kLink5,
  kLink6,
  kLink7,
  kHand,
  kCamera,
  kLeftFinger,
  kRightFinger,
};
inline constexpr int kLinkCount = 12;

// Start pose of all tasks: seven arm joints, two fingers.
inline constexpr std::array<double, 9> kStartPose = {
    0, 0, 0, -2.0943951023931953, 0, 2.0943951023931953, 0.7853981633974483, 0.04, 0.04};

inline constexpr int kWorldParent = -1;

// A link: its pose in its parent, and its inertia about the centre of mass in its own axes, as xx,
// yy, zz, xy, xz, yz.
struct LinkSpec {
  const char* name;
  int parent;  // a Link, or kWorldParent
  Vec3 pos;
  Vec3 rpy;
  double mass;
  Vec3 com;
  std::array<double, 6> inertia;
};

struct JointSpec {
  const char* name;
  Link link;
  const char* type;
  Vec3 axis;
  double lower, upper;  // rad or m
};

const LinkSpec& link_spec(Link link);
const char* link_name(Link link);
bool is_finger(Link link);

// Arm joints, then fingers: the order of qpos.
std::span<const JointSpec> joint_specs();

}  // namespace engram::mjcf
