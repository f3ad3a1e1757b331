#include "mjcf/panda.h"

#include <utility>

namespace engram::mjcf {
namespace {

// Drive: 1000 (target - q) - 100 qdot. The damping is the joint's, which the Euler integrator
// takes implicitly. As the actuator's it would be unstable at 0.01 s.
constexpr double kStiffness = 1000;
constexpr double kDamping = 100;
constexpr double kForceLimit = 100;

// Rotor inertia: very little for the arm. 1 kg for the fingers: with their own 15 g, the stiff
// drive would squeeze them through what they hold. They stay overdamped, as in the original.
constexpr double kArmArmature = 0.005;
constexpr double kFingerArmature = 1;

// The original couples the fingers by a spring of 1e5 N/m, too stiff to integrate explicitly. An
// equality constraint would couple robot and props in the solver. So this is a softer spring.
constexpr double kMimicStiffness = 2000;

// The tool centre point, between the finger tips.
constexpr Vec3 kTcp = {0, 0, 0.1034};

void add_joint(Element& body, const JointSpec& joint) {
  Element& element = add(body, "joint");
  set(element, "name", joint.name);
  set(element, "type", joint.type);
  set(element, "axis", joint.axis);
  set(element, "limited", "true");
  set(element, "range", {joint.lower, joint.upper});
  set(element, "damping", kDamping);
  set(element, "armature", is_finger(joint.link) ? kFingerArmature : kArmArmature);
}

void add_inertia(Element& element, const LinkSpec& body) {
  Element& inertial = add(element, "inertial");
  set(inertial, "mass", body.mass);
  set(inertial, "pos", body.com);
  set(inertial, "fullinertia", body.inertia);
}

Element& add_body(Element& parent, const LinkSpec& body) {
  Element& element = add(parent, "body");
  set(element, "name", body.name);
  set(element, "pos", body.pos);
  if (body.rpy != Vec3{}) set(element, "euler", body.rpy);
  return element;
}

}  // namespace

Element& add_panda(Element& worldbody, const std::function<bool(Link link)>& is_carried,
                   const std::function<void(Element& body, Link link)>& add_geoms) {
  std::array<Element*, kLinkCount> elements{};
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const Link link = static_cast<Link>(i);
    const int parent = link_spec(link).parent;
    Element& parent_element =
        parent == kWorldParent ? worldbody : *elements[static_cast<std::size_t>(parent)];
    elements[i] = &add_body(parent_element, link_spec(link));
    if (!is_carried(link)) continue;
    add_inertia(*elements[i], link_spec(link));
    for (const JointSpec& joint : joint_specs()) {
      if (joint.link == link) add_joint(*elements[i], joint);
    }
    add_geoms(*elements[i], link);
  }
  return *elements[static_cast<std::size_t>(Link::kHand)];
}

void add_tcp_site(Element& hand) {
  Element& tcp = add(hand, "site");
  set(tcp, "name", "tcp");
  set(tcp, "pos", kTcp);
  set(tcp, "size", 0.004);
  set(tcp, "group", 4);  // hidden by viewers by default
}

void add_finger_tendon(Element& root) {
  Element& tendon = add(add(root, "tendon"), "fixed");
  set(tendon, "name", "finger_mimic");
  set(tendon, "stiffness", kMimicStiffness);
  set(tendon, "springlength", 0.0);
  for (const auto& [joint, coefficient] :
       {std::pair{"finger_joint1", 1.0}, {"finger_joint2", -1.0}}) {
    Element& element = add(tendon, "joint");
    set(element, "joint", joint);
    set(element, "coef", coefficient);
  }
}

void add_drives(Element& root) {
  Element& actuators = add(root, "actuator");
  for (const JointSpec& joint : joint_specs()) {
    Element& drive = add(actuators, "general");
    set(drive, "name", joint.name);
    set(drive, "joint", joint.name);
    set(drive, "gainprm", kStiffness);
    set(drive, "biastype", "affine");
    set(drive, "biasprm", {0, -kStiffness, 0});
    set(drive, "forcelimited", "true");
    set(drive, "forcerange", {-kForceLimit, kForceLimit});
  }
}

}  // namespace engram::mjcf
