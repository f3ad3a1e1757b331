// What can touch what: every contact is an explicit pair, nothing else is tested.
#pragma once

#include <vector>

#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Name of the plane on which everything stands.
inline constexpr const char* kTableTop = "table_top";
// If the table ends, props stand on these instead: the table's block and the ground around it.
inline constexpr const char* kTableBlock = "table_block";
inline constexpr const char* kGround = "ground_plane";

// What the contacts of hard surfaces are like: stiff within two steps, no bounce. Pairs say what
// differs, so that the text is short: MuJoCo spends most of its time reading it.
void set_pair_defaults(Element& pair);

// Writes the pairs: robot with itself, robot with table, and then those of the props.
void add_contact_pairs(Element& root, const std::vector<Prop>& props, bool table_ends);

}  // namespace engram::mjcf
