#include "mjcf/panda_collision.h"

#include <numbers>

#include "mjcf/geom_element.h"

namespace engram::mjcf {
namespace {

// A capsule inside the shell of an arm link, in the link's frame.
struct Capsule {
  Link link;
  Vec3 from, to;
  double radius;
};

// The original uses convex hulls of the shells, whose numbers are not public. These are ours.
constexpr std::array kCapsules = {
    Capsule{Link::kLink0, {-0.09, 0, 0.06}, {0.01, 0, 0.06}, 0.075},  // foot
    Capsule{Link::kLink1, {0, 0, -0.19}, {0, -0.03, -0.03}, 0.057},   // column
    Capsule{Link::kLink2, {0, 0, -0.06}, {0, 0, 0.06}, 0.058},        // shoulder barrel
    Capsule{Link::kLink3, {0, 0, -0.17}, {0.05, 0, 0}, 0.054},        // upper arm
    Capsule{Link::kLink4, {0, 0, 0}, {-0.0825, 0.1, 0}, 0.056},       // elbow
    Capsule{Link::kLink5, {0, 0, -0.29}, {0, 0.01, -0.21}, 0.055},    // forearm, upper part
    Capsule{Link::kLink5, {0, 0.06, -0.17}, {0, 0.062, 0}, 0.045},    // forearm, lower part
    Capsule{Link::kLink6, {0, 0, 0}, {0.088, 0, 0}, 0.047},           // wrist
    Capsule{Link::kLink7, {0, 0, -0.01}, {0, 0, 0.065}, 0.045},       // flange
};

struct Box {
  Link link;
  Vec3 center, half_size;
  double roll;  // rad, about the link's x axis
};

// Hand (ours), wrist camera and the four boxes of a finger (the original's). The original's hand
// is a hull that narrows towards the fingers: of the hand's boxes the second is its end there, and
// both together have its extents.
constexpr double kFingerTilt = std::numbers::pi / 6;
constexpr std::array kBoxes = {
    Box{Link::kHand, {0, -0.0018, 0.00705}, {0.0316, 0.1022, 0.03295}, 0},
    Box{Link::kHand, {0, 0, 0.04298}, {0.016, 0.08, 0.02298}, 0},
    Box{Link::kCamera, {-0.0125, -0.02, 0}, {0.010025, 0.0495, 0.0115}, 0},
    Box{Link::kLeftFinger, {0, 0.0185, 0.011}, {0.011, 0.0075, 0.01}, 0},
    Box{Link::kLeftFinger, {0, 0.0068, 0.0022}, {0.011, 0.0044, 0.0019}, 0},
    Box{Link::kLeftFinger, {0, 0.0159, 0.02835}, {0.00875, 0.0035, 0.01175}, kFingerTilt},
    Box{Link::kLeftFinger, {0, 0.00758, 0.04525}, {0.00875, 0.0076, 0.00925}, 0},
};

// The right finger is the left one mirrored in y.
constexpr Box mirrored(Box box) {
  box.center[1] = -box.center[1];
  box.roll = -box.roll;
  return box;
}

Link table_link(Link link) { return link == Link::kRightFinger ? Link::kLeftFinger : link; }

}  // namespace

void add_collision_geoms(Element& body, Link link) {
  int index = 0;
  const auto finish = [&](Element& geom) {
    set(geom, "name", collision_geom_name(link, index++));
    set(geom, "group", kCollisionGroup);
  };
  for (const Capsule& capsule : kCapsules) {
    if (capsule.link != link) continue;
    finish(add_fromto_geom(body, GeomType::kCapsule, capsule.from, capsule.to, capsule.radius));
  }
  for (const Box& entry : kBoxes) {
    if (entry.link != table_link(link)) continue;
    const Box box = link == Link::kRightFinger ? mirrored(entry) : entry;
    finish(add_geom(body, GeomType::kBox, box.half_size, box.center, {box.roll, 0, 0}));
  }
}

int collision_geom_count(Link link) {
  int count = 0;
  for (const Capsule& capsule : kCapsules) count += capsule.link == link;
  for (const Box& box : kBoxes) count += box.link == table_link(link);
  return count;
}

std::string collision_geom_name(Link link, int index) {
  return std::string(link_name(link)) + "_collision_" + std::to_string(index);
}

}  // namespace engram::mjcf
