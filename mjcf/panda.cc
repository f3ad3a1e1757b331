#include "mjcf/panda.h"

#include <numbers>
#include <utility>

#include "mjcf/cameras.h"
#include "mjcf/panda_collision.h"
#include "mjcf/panda_visual.h"
#include "mjcf/prop.h"

namespace engram::mjcf {
namespace {

constexpr double kRight = std::numbers::pi / 2;
constexpr int kWorld = -1;

// A body: its pose in its parent, and its inertia about the centre of mass in its own axes, as xx,
// yy, zz, xy, xz, yz.
struct Body {
  const char* name;
  int parent;  // a Link, or kWorld
  Vec3 pos;
  Vec3 rpy;
  double mass;
  Vec3 com;
  std::array<double, 6> inertia;
};

// The hand includes the offset of the massless link8. The camera's angles have the original's
// truncated pi.
constexpr std::array<Body, kLinkCount> kBodies = {{
    {"link0",
     kWorld,
     {-0.615, 0, 0},
     {},
     0.629769,
     {-0.041018, -0.00014, 0.049974},
     {0.00315, 0.00388, 0.004285, 8.2904e-07, 0.00015, 8.2299e-06}},
    {"link1",
     0,
     {0, 0, 0.333},
     {},
     4.970684,
     {0.003875, 0.002081, -0.04762},
     {0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169}},
    {"link2",
     1,
     {},
     {-kRight, 0, 0},
     0.646926,
     {-0.003141, -0.02872, 0.003495},
     {0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704}},
    {"link3",
     2,
     {0, -0.316, 0},
     {kRight, 0, 0},
     3.228604,
     {0.027518, 0.039252, -0.066502},
     {0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805}},
    {"link4",
     3,
     {0.0825, 0, 0},
     {kRight, 0, 0},
     3.587895,
     {-0.05317, 0.104419, 0.027454},
     {0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641}},
    {"link5",
     4,
     {-0.0825, 0.384, 0},
     {-kRight, 0, 0},
     1.225946,
     {-0.011953, 0.041065, -0.038437},
     {0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229}},
    {"link6",
     5,
     {},
     {kRight, 0, 0},
     1.666555,
     {0.060149, -0.014117, -0.010517},
     {0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341}},
    {"link7",
     6,
     {0.088, 0, 0},
     {kRight, 0, 0},
     0.735522,
     {0.010517, -0.004252, 0.061597},
     {0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741}},
    {"hand",
     7,
     {0, 0, 0.107},
     {0, 0, -kRight / 2},
     0.73,
     {-0.01, 0, 0.03},
     {0.001, 0.0025, 0.0017, 0, 0, 0}},
    {"camera_link",
     8,
     {0.046498, -0.020001, 0.036001},
     {0, -1.5707, 3.1415},
     0.564,
     {},
     {0.003881243, 0.00049894, 0.003879257, 0, 0, 0}},
    {"leftfinger", 8, {0, 0, 0.0584}, {}, 0.015, {}, {2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0}},
    {"rightfinger", 8, {0, 0, 0.0584}, {}, 0.015, {}, {2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0}},
}};

struct Joint {
  const char* name;
  Link link;
  const char* type;
  Vec3 axis;
  double lower, upper;  // rad or m
};

constexpr std::array<Joint, 9> kJoints = {{
    {"joint1", Link::kLink1, "hinge", {0, 0, 1}, -2.8973, 2.8973},
    {"joint2", Link::kLink2, "hinge", {0, 0, 1}, -1.7628, 1.7628},
    {"joint3", Link::kLink3, "hinge", {0, 0, 1}, -2.8973, 2.8973},
    {"joint4", Link::kLink4, "hinge", {0, 0, 1}, -3.0718, -0.0698},
    {"joint5", Link::kLink5, "hinge", {0, 0, 1}, -2.8973, 2.8973},
    {"joint6", Link::kLink6, "hinge", {0, 0, 1}, -0.0175, 3.7525},
    {"joint7", Link::kLink7, "hinge", {0, 0, 1}, -2.8973, 2.8973},
    {"finger_joint1", Link::kLeftFinger, "slide", {0, 1, 0}, 0, 0.04},
    {"finger_joint2", Link::kRightFinger, "slide", {0, -1, 0}, 0, 0.04},
}};

// Drive law: 1000 (target - q) - 100 qdot. The damping is the joint's, which the Euler integrator
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

void add_joint(Element& body, const Joint& joint) {
  Element& element = add(body, "joint");
  const bool finger = joint.link == Link::kLeftFinger || joint.link == Link::kRightFinger;
  set(element, "name", joint.name);
  set(element, "type", joint.type);
  set(element, "axis", joint.axis);
  set(element, "limited", "true");
  set(element, "range", {joint.lower, joint.upper});
  set(element, "damping", kDamping);
  set(element, "armature", finger ? kFingerArmature : kArmArmature);
}

Element& add_body(Element& parent, const Body& body) {
  Element& element = add(parent, "body");
  set(element, "name", body.name);
  set(element, "pos", body.pos);
  if (body.rpy != Vec3{}) set(element, "euler", body.rpy);

  Element& inertial = add(element, "inertial");
  set(inertial, "mass", body.mass);
  set(inertial, "pos", body.com);
  set(inertial, "fullinertia", body.inertia);
  return element;
}

}  // namespace

const char* link_name(Link link) { return kBodies[static_cast<std::size_t>(link)].name; }

void add_panda(Element& worldbody, bool collisions, bool visuals) {
  std::array<Element*, kLinkCount> elements{};
  for (std::size_t i = 0; i < kBodies.size(); ++i) {
    const Body& body = kBodies[i];
    Element& parent =
        body.parent == kWorld ? worldbody : *elements[static_cast<std::size_t>(body.parent)];
    elements[i] = &add_body(parent, body);

    const Link link = static_cast<Link>(i);
    for (const Joint& joint : kJoints) {
      if (joint.link == link) add_joint(*elements[i], joint);
    }
    if (collisions) add_collision_geoms(*elements[i], link);
    if (visuals) add_visual_geoms(*elements[i], link);
  }

  Element& hand = *elements[static_cast<std::size_t>(Link::kHand)];
  if (visuals) add_hand_camera(hand);
  Element& tcp = add(hand, "site");
  set(tcp, "name", "tcp");
  set(tcp, "pos", kTcp);
  set(tcp, "size", 0.004);
  set(tcp, "group", 4);  // viewers hide this group unless told otherwise
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
  for (const Joint& joint : kJoints) {
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
