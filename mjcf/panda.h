// The Franka Panda with its wrist camera: bodies, joints, drives. See docs/robot.md.
#pragma once

#include <array>
#include <string>

#include "mjcf/xml.h"

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

const char* link_name(Link link);

// Start pose of all tasks: seven arm joints, two fingers.
inline constexpr std::array<double, 9> kStartPose = {
    0, 0, 0, -2.0943951023931953, 0, 2.0943951023931953, 0.7853981633974483, 0.04, 0.04};

// Writes the bodies into the worldbody; with visuals, also their shells and the wrist camera.
void add_panda(Element& worldbody, bool collisions, bool visuals);

// Drives and finger coupling, children of the document's root.
void add_finger_tendon(Element& root);
void add_drives(Element& root);

}  // namespace engram::mjcf
