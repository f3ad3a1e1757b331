// Collision pairs: every contact is between the geoms of an explicit pair, nothing else is tested.
#pragma once

#include <functional>
#include <vector>

#include "mjcf/panda_spec.h"
#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Name of the plane on which everything stands.
inline constexpr const char* kTableTop = "table_top";
// If the table has edges, props stand on these instead: the table's block and the ground around it.
inline constexpr const char* kTableBlock = "table_block";
inline constexpr const char* kGround = "ground_plane";

// Defaults are the contacts of hard surfaces: stiff within two steps, no restitution. Pairs list
// only what differs, because MuJoCo spends most of its compile time parsing them.
void set_pair_defaults(Element& pair);

// Writes the pairs: robot with itself, robot with table, and then those of the props. Links that
// the robot does not carry have none.
void add_contact_pairs(Element& root, const std::vector<Prop>& props, bool table_ends,
                       const std::function<bool(Link link)>& is_carried);

}  // namespace engram::mjcf
