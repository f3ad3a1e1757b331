#include "mjcf/panda_spec.h"

#include <numbers>

namespace engram::mjcf {
namespace {

constexpr double kRight = std::numbers::pi / 2;

// The hand includes the offset of the massless link8. The camera's angles have the original's
// truncated pi.
constexpr std::array<LinkSpec, kLinkCount> kLinks = {{
    {"link0",
     kWorldParent,
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

constexpr std::array<JointSpec, 9> kJoints = {{
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

}  // namespace

const LinkSpec& link_spec(Link link) { return kLinks[static_cast<std::size_t>(link)]; }

const char* link_name(Link link) { return link_spec(link).name; }

std::span<const JointSpec> joint_specs() { return kJoints; }

bool is_finger(Link link) { return link == Link::kLeftFinger || link == Link::kRightFinger; }

}  // namespace engram::mjcf
