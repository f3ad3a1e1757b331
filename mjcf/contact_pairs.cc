#include "mjcf/contact_pairs.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "mjcf/footing.h"
#include "mjcf/panda_collision.h"
#include "mjcf/prop_body.h"

namespace engram::mjcf {
namespace {

// A material: sliding friction, and the radius of the patch by which it resists twisting. The
// rubber tips have the original benchmark's; hard surfaces get a small one.
struct Material {
  double friction = 0.3;
  double patch = 0.005;  // m
};
constexpr Material kHard{};
constexpr Material kRubber{.friction = 2.0, .patch = 0.1};

std::array<double, 5> pair_friction(double sliding, double patch) {
  return {sliding, sliding, sliding * patch, 1e-4, 1e-4};
}

// How deep soft contacts let a resting prop sink, whatever it weighs, if it stands on four of them;
// more contacts share its weight. The table's contacts begin that much earlier. So props rest at
// the height of their shapes, where tasks place them, and wake without a jolt.
constexpr double kSinkageOnFour = 1e-5;  // m

// The fingers' contacts are harder than the default. With that, 30 N of grip would sink 1.5 mm into
// a cube of 64 g; with this, 0.2 mm. Even harder ones cost solver iterations.
constexpr std::array<double, 3> kGripImpedance = {0.99, 0.999, 0.0002};
// So are those of what stands: a hand that presses with all its force pushes a cube 0.5 mm into the
// table; with the default, 6 mm.
constexpr std::array<double, 3> kStandingImpedance = {0.99, 0.999, 0.0007};

// Where a contact begins, m above the surface: where it pushes, and how far above that it is
// foreseen (core/contact/contact_filter.h). MuJoCo's own step knows nothing of the latter.
struct Onset {
  double push = 0;
  double foresight = 0;
};
constexpr double kTableForesight = 0.02;  // as in the original: the way of a substep at 2 m/s

// What glides pushes from a millimetre on, so that contacts last: what is pushed would rattle.
constexpr Onset kGliding{.push = 0.001, .foresight = 0.005};

// Geoms of one material that collide alike.
struct Side {
  std::vector<std::string> geoms;
  Material material;
};

Side side(Link link) {
  const bool finger = link == Link::kLeftFinger || link == Link::kRightFinger;
  Side result{{}, finger ? kRubber : kHard};
  for (int i = 0; i < collision_geom_count(link); ++i) {
    result.geoms.push_back(collision_geom_name(link, i));
  }
  return result;
}

Side side(const Prop& prop) {
  return {collision_geom_names(prop), {.friction = prop.friction, .patch = kHard.patch}};
}

// Pairs every geom of one side with every geom of the other. The friction is the average of both,
// as in PhysX; MuJoCo by itself would take the larger one.
void add_pairs(Element& contact, const Side& first, const Side& second, const Onset& onset = {}) {
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
      if (gripping) set(pair, "solimp", kGripImpedance);
      if (!gripping && onset.push > 0) set(pair, "solimp", kStandingImpedance);
      if (onset.push + onset.foresight > 0) set(pair, "margin", onset.push + onset.foresight);
      if (onset.foresight > 0) set(pair, "gap", onset.foresight);
    }
  }
}

// Self-collisions, those of the original benchmark.
void add_self_pairs(Element& contact) {
  using enum Link;
  const std::pair<Link, std::vector<Link>> table[] = {
      {kLink0, {kLink5, kLink6, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink1, {kLink5, kLink6, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink2, {kLink5, kLink7, kHand, kCamera, kLeftFinger, kRightFinger}},
      {kLink3, {kCamera}},
      {kLink4, {kCamera}},
      {kLink5, {kCamera, kLeftFinger, kRightFinger}},
  };
  for (const auto& [link, others] : table) {
    for (const Link other : others) add_pairs(contact, side(link), side(other));
  }
}

// The base stands on the table and link1 cannot reach it.
void add_table_pairs(Element& contact) {
  const Side table{{kTableTop}, kHard};
  for (int i = static_cast<int>(Link::kLink2); i < kLinkCount; ++i) {
    add_pairs(contact, table, side(static_cast<Link>(i)));
  }
}

// The links that can reach a prop: all after the elbow.
void add_prop_pairs(Element& contact, const Prop& prop, const Side& support) {
  const Side own = side(prop);
  for (int i = static_cast<int>(Link::kLink5); i < kLinkCount; ++i) {
    add_pairs(contact, side(static_cast<Link>(i)), own);
  }
  if (prop.motion == Motion::kFree) {
    const double sinkage = kSinkageOnFour * 4 / standing_contacts(prop);
    add_pairs(contact, support, own, {.push = sinkage, .foresight = kTableForesight});
  }
}

}  // namespace

void set_pair_defaults(Element& pair) {
  set(pair, "condim", 4);
  set(pair, "friction", pair_friction(kHard.friction, kHard.patch));
  set(pair, "solref", {0.02, 1});
  set(pair, "solimp", {0.95, 0.99, 0.001});
}

void add_contact_pairs(Element& root, const std::vector<Prop>& props, bool table_ends) {
  Element& contact = add(root, "contact");
  Side support{{kTableTop}, kHard};
  if (table_ends) support.geoms = {kTableBlock, kGround};
  add_self_pairs(contact);
  add_table_pairs(contact);
  for (std::size_t i = 0; i < props.size(); ++i) {
    add_prop_pairs(contact, props[i], support);
    for (std::size_t j = 0; j < i; ++j) {
      const bool either_moves =
          props[i].motion == Motion::kFree || props[j].motion == Motion::kFree;
      const bool either_glides = props[i].glides || props[j].glides;
      const Onset onset = either_glides ? kGliding : Onset{};
      if (either_moves) add_pairs(contact, side(props[j]), side(props[i]), onset);
    }
  }
}

}  // namespace engram::mjcf
