#include "mjcf/panda_visual.h"

#include <numbers>

#include "mjcf/geom_element.h"

namespace engram::mjcf {
namespace {

using enum Link;

// Colours as displayed: the arm's, and the grey of the camera.
enum class Finish { kShell, kTrim, kBlack, kSilver };

struct FinishEntry {
  const char* name;
  Rgba rgba;
  double specular;
};
constexpr std::array<FinishEntry, 4> kFinishes = {{
    {"shell", {0.954, 0.964, 0.967, 1}, 0.3},
    {"trim", {1, 1, 1, 1}, 0.3},
    {"black", {0.2565, 0.2565, 0.2565, 1}, 0.2},
    {"silver", {0.71, 0.71, 0.71, 1}, 0.5},
}};

// A capsule or cylinder from one point to another, in the link's frame.
struct FromToGeom {
  Link link;
  Finish finish;
  GeomType type;
  Vec3 from, to;
  double radius;
};

constexpr GeomType kCapsule = GeomType::kCapsule;
constexpr GeomType kCylinder = GeomType::kCylinder;
constexpr Finish kShell = Finish::kShell;
constexpr Finish kTrim = Finish::kTrim;
constexpr Finish kBlack = Finish::kBlack;
constexpr Finish kSilver = Finish::kSilver;

constexpr std::array kFromToGeoms = {
    // Base column.
    FromToGeom{kLink0, kShell, kCylinder, {0, 0, 0}, {0, 0, 0.1405}, 0.056},
    // Column of the first joint with a round top, neck, half of the shoulder barrel.
    FromToGeom{kLink1, kTrim, kCylinder, {0, 0, -0.192}, {0, 0, -0.189}, 0.0555},
    FromToGeom{kLink1, kShell, kCapsule, {0, 0, -0.19}, {0, 0, -0.125}, 0.0535},
    FromToGeom{kLink1, kShell, kCapsule, {0, -0.0205, -0.101}, {0, -0.052, -0.03}, 0.048},
    FromToGeom{kLink1, kShell, kCapsule, {0, -0.021, 0}, {0, -0.073, 0}, 0.0505},
    FromToGeom{kLink1, kShell, kCylinder, {0, 0, 0}, {0, -0.057, 0}, 0.055},
    // The other half, neck, and the upper arm's lower part.
    FromToGeom{kLink2, kShell, kCylinder, {0, 0, 0}, {0, 0, 0.058}, 0.0545},
    FromToGeom{kLink2, kShell, kCapsule, {0, 0, 0.02}, {0, 0, 0.0713}, 0.056},
    FromToGeom{kLink2, kShell, kCapsule, {0, -0.036, 0.06}, {0, -0.1, 0.023}, 0.0465},
    FromToGeom{kLink2, kShell, kCapsule, {0, -0.129, 0.01}, {0, -0.16, 0}, 0.052},
    FromToGeom{kLink2, kShell, kCylinder, {0, -0.126, 0}, {0, -0.194, 0}, 0.053},
    // Upper arm, elbow; its caps are among the blocks.
    FromToGeom{kLink3, kTrim, kCylinder, {0, 0, -0.122}, {0, 0, -0.119}, 0.0525},
    FromToGeom{kLink3, kShell, kCylinder, {0, 0, -0.119}, {0, 0, -0.06}, 0.052},
    FromToGeom{kLink3, kShell, kCapsule, {0.004, 0, -0.06}, {0.06, 0.02, -0.005}, 0.052},
    FromToGeom{kLink3, kShell, kCylinder, {0.0825, 0, 0}, {0.0825, 0.05, 0}, 0.053},
    FromToGeom{kLink3, kShell, kCylinder, {0.0825, 0.08, 0}, {0.0825, 0.1085, 0}, 0.022},
    FromToGeom{kLink4, kShell, kCylinder, {0, 0, 0}, {0, 0, 0.05}, 0.053},
    FromToGeom{kLink4, kShell, kCylinder, {0, 0, 0.08}, {0, 0, 0.1045}, 0.022},
    FromToGeom{kLink4, kShell, kCapsule, {-0.028, 0.005, 0.0115}, {-0.0785, 0.071, 0}, 0.0505},
    FromToGeom{kLink4, kShell, kCylinder, {-0.0825, 0.069, 0}, {-0.0825, 0.122, 0}, 0.0555},
    // Forearm: its upper end, the slim arm to the wrist with its dark panel, the wrist's barrel.
    FromToGeom{kLink5, kTrim, kCylinder, {0, 0, -0.262}, {0, 0, -0.259}, 0.0555},
    FromToGeom{kLink5, kShell, kCapsule, {0, 0.006, -0.259}, {0, 0.0025, -0.228}, 0.0505},
    FromToGeom{kLink5, kShell, kCapsule, {0, 0.02, -0.209}, {0, 0.057, -0.158}, 0.0365},
    FromToGeom{kLink5, kShell, kCapsule, {0, 0.074, -0.155}, {0, 0.07, -0.02}, 0.024},
    FromToGeom{kLink5, kBlack, kCapsule, {0, 0.078, -0.175}, {0, 0.096, -0.015}, 0.02},
    FromToGeom{kLink5, kShell, kCapsule, {0, 0.088, -0.165}, {0, 0.1045, -0.03}, 0.0125},
    FromToGeom{kLink5, kShell, kCylinder, {0, 0.043, 0}, {0, 0.066, 0}, 0.05},
    FromToGeom{kLink5, kBlack, kCylinder, {0, 0.066, 0}, {0, 0.105, 0}, 0.051},
    FromToGeom{kLink5, kShell, kCylinder, {0, 0.115, 0}, {0, 0.1295, 0}, 0.022},
    // Wrist: the barrel of joint 6, the upright body, its black lid.
    FromToGeom{kLink6, kShell, kCylinder, {0, 0, 0.03}, {0, 0, -0.045}, 0.047},
    FromToGeom{kLink6, kBlack, kCylinder, {0, 0, 0.044}, {0, 0, 0.053}, 0.045},
    FromToGeom{kLink6, kShell, kCapsule, {0, 0, 0.005}, {0.075, 0, 0.002}, 0.043},
    FromToGeom{kLink6, kShell, kCylinder, {0.088, -0.048, 0}, {0.088, 0.052, 0}, 0.0435},
    FromToGeom{kLink6, kShell, kCylinder, {0.088, 0.052, 0}, {0.088, 0.06, 0}, 0.042},
    FromToGeom{kLink6, kBlack, kCylinder, {0.088, 0.06, 0}, {0.088, 0.067, 0}, 0.039},
    // Flange.
    FromToGeom{kLink7, kTrim, kCylinder, {0, 0, 0.048}, {0, 0, 0.051}, 0.044},
    FromToGeom{kLink7, kShell, kCylinder, {0, 0, 0.051}, {0, 0, 0.098}, 0.043},
    // Hand: the collar around the flange, rounded ends.
    FromToGeom{kHand, kShell, kCylinder, {0, 0, -0.009}, {0, 0, -0.006}, 0.043},
    FromToGeom{kHand, kShell, kCylinder, {0, 0.075, 0.002}, {0, 0.075, 0.054}, 0.027},
    FromToGeom{kHand, kShell, kCylinder, {0, -0.075, -0.006}, {0, -0.075, 0.054}, 0.027},
    // Camera: lens.
    FromToGeom{kCamera, kBlack, kCylinder, {-0.002, 0, 0}, {0, 0, 0}, 0.006},
};

// A box or ellipsoid, rotated about the link's x axis, then about its z axis.
struct Block {
  Link link;
  Finish finish;
  GeomType type;
  Vec3 center, half_size;
  double roll = 0;
  double yaw = 0;
};

constexpr GeomType kBox = GeomType::kBox;
constexpr GeomType kEllipsoid = GeomType::kEllipsoid;
constexpr double kTilt = std::numbers::pi / 6;
constexpr double kEighth = std::numbers::pi / 4;  // from the flange to the hand

constexpr std::array kBlocks = {
    // Foot.
    Block{kLink0, kShell, kEllipsoid, {0.002, 0.002, 0}, {0.076, 0.08, 0.19}},
    Block{kLink0, kShell, kBox, {-0.085, 0, 0.045}, {0.045, 0.05, 0.045}},
    Block{kLink0, kTrim, kBox, {-0.125, 0, 0.006}, {0.025, 0.07, 0.006}},
    // Black caps of the elbow and of the wrist.
    Block{kLink3, kBlack, kEllipsoid, {0.0825, 0.066, 0}, {0.0575, 0.042, 0.0575}},
    Block{kLink4, kBlack, kEllipsoid, {0, 0, 0.066}, {0.056, 0.056, 0.038}},
    Block{kLink5, kBlack, kEllipsoid, {0, 0.105, 0}, {0.05, 0.024, 0.05}},
    // The flange's grip, with a black front, in the hand's axes.
    Block{kLink7, kShell, kBox, {0.0385, 0.0442, 0.085}, {0.028, 0.0275, 0.014}, 0, -kEighth},
    Block{kLink7, kBlack, kBox, {0.0573, 0.0226, 0.083}, {0.001, 0.0175, 0.011}, 0, -kEighth},
    // The hand tapers towards the fingers, out of the wrist camera's sight.
    Block{kHand, kShell, kBox, {0, 0, 0.024}, {0.027, 0.075, 0.030}},
    Block{kHand, kShell, kBox, {0, 0, 0.06}, {0.015, 0.095, 0.006}},
    // Above its other end: a ledge, and a black one behind it.
    Block{kHand, kShell, kBox, {0.0135, -0.068, -0.008}, {0.0105, 0.027, 0.0077}},
    Block{kHand, kBlack, kBox, {-0.020, -0.074, -0.0095}, {0.006, 0.029, 0.0060}},
    Block{kCamera, kSilver, kBox, {-0.00775, -0.0215, 0.0005}, {0.00775, 0.0465, 0.012}},
    Block{kLeftFinger, kShell, kBox, {0, 0.0185, 0.00915}, {0.011, 0.0075, 0.00815}},
    Block{kLeftFinger, kShell, kBox, {0, 0.0068, 0.0022}, {0.011, 0.0044, 0.0019}},
    Block{kLeftFinger, kShell, kBox, {0, 0.01728, 0.02597}, {0.00875, 0.0035, 0.0145}, kTilt},
    Block{kLeftFinger, kShell, kBox, {0, 0.0108, 0.04185}, {0.0085, 0.0040, 0.00535}},
    Block{kLeftFinger, kBlack, kBox, {0, 0.0045, 0.04155}, {0.00875, 0.0045, 0.00565}},
    Block{kLeftFinger, kShell, kBox, {0, 0.0132, 0.05055}, {0.0065, 0.0017, 0.00335}},
    Block{kLeftFinger, kBlack, kBox, {0, 0.00575, 0.05085}, {0.0065, 0.00575, 0.00365}},
};

constexpr Block mirrored(Block block) {
  block.center[1] = -block.center[1];
  block.roll = -block.roll;
  return block;
}

void paint(Element& geom, Finish finish) {
  set(geom, "group", kVisualGroup);
  set(geom, "material", kFinishes[static_cast<std::size_t>(finish)].name);
}

}  // namespace

void add_panda_materials(Element& assets) {
  for (const FinishEntry& finish : kFinishes) {
    Element& material = add(assets, "material");
    set(material, "name", finish.name);
    set(material, "rgba", finish.rgba);
    set(material, "specular", finish.specular);
    set(material, "shininess", 0.3);
  }
}

void add_visual_geoms(Element& body, Link link) {
  for (const FromToGeom& geom : kFromToGeoms) {
    if (geom.link == link) {
      paint(add_fromto_geom(body, geom.type, geom.from, geom.to, geom.radius), geom.finish);
    }
  }
  const bool right = link == kRightFinger;
  for (const Block& entry : kBlocks) {
    if (entry.link != (right ? kLeftFinger : link)) continue;
    const Block block = right ? mirrored(entry) : entry;
    paint(add_geom(body, block.type, block.half_size, block.center, {block.roll, 0, block.yaw}),
          block.finish);
  }
}

}  // namespace engram::mjcf
