#include "mjcf/panda.h"

#include <array>
#include <utility>

namespace engram::mjcf {
namespace {

// Drive: 1000 (target - q) - 100 qdot, a net force of at most 100.
constexpr double kStiffness = 1000;
constexpr double kDamping = 100;
constexpr double kForceLimit = 100;

// MuJoCo adds up forces at a substep's start, where these would be unstable, and solves contacts
// before it integrates a joint's damping. Taken implicitly, (M + h D + s h^2 K) dv is equal to
// h (K (target - q) - (D + s h K) v), with s = 1 for the speed at the substep's end and s = 1/2 for
// the mean speed. So the left side's part is rotor inertia, the right side's an actuator, and
// contacts see the joint that resists them. The mean follows the original's arm best; the fingers
// are lighter than that allows.
constexpr double kArmShare = 0.5;
constexpr double kFingerShare = 1;

double end_share(const JointSpec& joint) {
  return is_finger(joint.link) ? kFingerShare : kArmShare;
}

// The rotor inertia takes up about half of the force by which a joint accelerates.
constexpr double kAppliedForceLimit = 2 * kForceLimit;

// Joint limits are nearly rigid: closed fingers press each other less than 0.05 mm beyond theirs.
constexpr std::array<double, 3> kLimitImpedance = {0.99, 0.999, 0.001};

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
  set(element, "solimplimit", kLimitImpedance);
  set(element, "armature", kTimestep * (kDamping + end_share(joint) * kTimestep * kStiffness));
}

Element& add_body(Element& parent, const LinkSpec& body) {
  Element& element = add(parent, "body");
  set(element, "name", body.name);
  set(element, "pos", body.pos);
  set_rotation(element, body.rpy);
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
    const LinkSpec& spec = link_spec(link);
    add_inertial(*elements[i], spec.mass, spec.com, spec.inertia);
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
    set(drive, "biasprm",
        {0, -kStiffness, -(kDamping + end_share(joint) * kTimestep * kStiffness)});
    set(drive, "forcelimited", "true");
    set(drive, "forcerange", {-kAppliedForceLimit, kAppliedForceLimit});
    set(drive, "user", {kStiffness, kDamping, kForceLimit});
  }
}

}  // namespace engram::mjcf
