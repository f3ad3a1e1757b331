#include "mjcf/contact_pairs.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "mjcf/panda_collision.h"
#include "mjcf/prop_body.h"
#include "mjcf/table_contact.h"

namespace engram::mjcf {
namespace {

// A material: sliding friction, and the radius of the contact patch, which gives torsional
// friction. Only the rubber tips have one.
struct Material {
  double friction = 0.3;
  double patch = 0;  // m
};
constexpr Material kHard{};
constexpr Material kRubber{.friction = 2.0, .patch = 0.1};

std::array<double, 5> pair_friction(double sliding, double patch) {
  return {sliding, sliding, sliding * patch, 1e-4, 1e-4};
}

// Softness and onset of contacts are for MuJoCo's own step: the engine solves contacts by another
// law (core/contact).

// Penetration of a resting prop into soft contacts, whatever it weighs, if it stands on four of
// them; more contacts share its weight. The table's contacts begin that much earlier. So props rest
// at the height of their shapes, where tasks place them, and wake without a jolt.
constexpr double kPenetrationOnFour = 1e-5;  // m

// The fingers' contacts are harder than the default. With that, fingers would sink 1.5 mm under 30
// N into a cube of 64 g; with this, 0.2 mm. Even harder ones cost solver iterations.
constexpr std::array<double, 3> kGripImpedance = {0.99, 0.9996, 0.0002};
// Props that rest: a hand that presses with all its force pushes a cube 0.5 mm into the table; with
// the default, 6 mm.
constexpr std::array<double, 3> kStandingImpedance = {0.99, 0.999, 0.0007};

// Stiffness and damping of an overlap, 1/s^2 and 1/s, where the robot touches a prop. The damping
// stops them within a substep; the stiffness takes out a tenth of the overlap in each, as a speed
// apart. With the default, 0.25, props jump away from a fast hand and tremble before a slow one.
constexpr std::array<double, 2> kTouchReference = {-1000, -100};  // negative: direct values

// Height above the surface at which kinematic props push already, so that contacts last and pushed
// props do not rattle, m.
constexpr double kPushingMargin = 0.001;

// Geoms of one material that collide alike.
struct GeomGroup {
  std::vector<std::string> geoms;
  Material material;
};

// The robot's, by link.
using LinkGroups = std::array<GeomGroup, kLinkCount>;

GeomGroup group_of(Link link) {
  GeomGroup result{{}, is_finger(link) ? kRubber : kHard};
  for (int i = 0; i < collision_geom_count(link); ++i) {
    result.geoms.push_back(collision_geom_name(link, i));
  }
  return result;
}

LinkGroups groups_of_robot(const std::function<bool(Link link)>& is_carried) {
  LinkGroups robot;
  for (std::size_t i = 0; i < robot.size(); ++i) {
    const Link link = static_cast<Link>(i);
    if (is_carried(link)) robot[i] = group_of(link);
  }
  return robot;
}

GeomGroup group_of(const Prop& prop) {
  return {collision_geom_names(prop), {.friction = prop.friction, .patch = kHard.patch}};
}

// Pairs every geom of one group with every geom of the other. The friction is the average of both,
// as in PhysX; MuJoCo by itself would take the larger one.
void add_pairs(Element& contact, const GeomGroup& first, const GeomGroup& second, double margin = 0,
               bool robot_and_prop = false) {
  const double friction = (first.material.friction + second.material.friction) / 2;
  const double patch = std::max(first.material.patch, second.material.patch);
  const bool gripping = patch == kRubber.patch;
  const bool usual = friction == kHard.friction && patch == kHard.patch;
  for (const std::string& geom1 : first.geoms) {
    for (const std::string& geom2 : second.geoms) {
      Element& pair = add(contact, "pair");
      set(pair, "geom1", geom1);
      set(pair, "geom2", geom2);
      if (!usual) set(pair, "friction", pair_friction(friction, patch));
      if (robot_and_prop) set(pair, "solref", kTouchReference);
      if (gripping) set(pair, "solimp", kGripImpedance);
      if (!gripping && margin > 0) set(pair, "solimp", kStandingImpedance);
      if (margin > 0) set(pair, "margin", margin);
    }
  }
}

// Self-collisions, those of the original benchmark.
void add_self_pairs(Element& contact, const LinkGroups& robot) {
  using enum Link;
  const std::pair<Link, std::vector<Link>> table[] = {
      {kLink0, {kLink5, kLink6, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink1, {kLink5, kLink6, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink2, {kLink5, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink3, {kCamera}},
      {kLink4, {kCamera}},
      {kLink5, {kCamera, kLeftFinger, kRightFinger}},
  };
  const auto group = [&robot](Link link) { return robot[static_cast<std::size_t>(link)]; };
  for (const auto& [link, others] : table) {
    for (const Link other : others) add_pairs(contact, group(link), group(other));
  }
}

// The base stands on the table and link1 cannot reach it.
void add_table_pairs(Element& contact, const LinkGroups& robot) {
  const GeomGroup table{{kTableTop}, kHard};
  for (auto i = static_cast<std::size_t>(Link::kLink2); i < robot.size(); ++i) {
    add_pairs(contact, table, robot[i]);
  }
}

// The links that can reach a prop: all after the elbow.
void add_prop_pairs(Element& contact, const LinkGroups& robot, const Prop& prop,
                    const GeomGroup& support) {
  const GeomGroup own = group_of(prop);
  for (auto i = static_cast<std::size_t>(Link::kLink5); i < robot.size(); ++i) {
    add_pairs(contact, robot[i], own, 0, true);
  }
  if (prop.body_type == BodyType::kDynamic) {
    const double penetration = kPenetrationOnFour * 4 / table_contact_count(prop);
    add_pairs(contact, support, own, penetration);
  }
}

}  // namespace

void set_pair_defaults(Element& pair) {
  set(pair, "condim", 4);
  set(pair, "friction", pair_friction(kHard.friction, kHard.patch));
  set(pair, "solref", {0.02, 1});
  set(pair, "solimp", {0.95, 0.99, 0.001});
}

void add_contact_pairs(Element& root, const std::vector<Prop>& props, bool table_ends,
                       const std::function<bool(Link link)>& is_carried) {
  const LinkGroups robot = groups_of_robot(is_carried);
  Element& contact = add(root, "contact");
  GeomGroup support{{kTableTop}, kHard};
  if (table_ends) support.geoms = {kTableBlock, kGround};
  add_self_pairs(contact, robot);
  add_table_pairs(contact, robot);
  for (std::size_t i = 0; i < props.size(); ++i) {
    add_prop_pairs(contact, robot, props[i], support);
    for (std::size_t j = 0; j < i; ++j) {
      const bool either_dynamic =
          props[i].body_type == BodyType::kDynamic || props[j].body_type == BodyType::kDynamic;
      const bool either_pushes = props[i].pushes_props || props[j].pushes_props;
      const double margin = either_pushes ? kPushingMargin : 0;
      if (either_dynamic) add_pairs(contact, group_of(props[j]), group_of(props[i]), margin);
    }
  }
}

}  // namespace engram::mjcf
