// The Franka Panda with its wrist camera: bodies, joints, drives. See docs/robot.md.
#pragma once

#include <functional>

#include "mjcf/panda_spec.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

inline constexpr double kTimestep = 0.01;  // s: of a substep

// Writes the bodies into the worldbody. Links that are not carried have no inertia. `add_geoms` is
// called for the others, behind their joints and before their children. Returns the hand.
Element& add_panda(Element& worldbody, const std::function<bool(Link link)>& is_carried,
                   const std::function<void(Element& body, Link link)>& add_geoms);

// The site "tcp" of the hand.
void add_tcp_site(Element& hand);

// Drives and finger coupling, children of the document's root. A drive's user data are its
// stiffness, damping and force limit, which engram's own physics takes in another way.
void add_finger_tendon(Element& root);
void add_drives(Element& root);

}  // namespace engram::mjcf
