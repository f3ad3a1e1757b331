// Who can touch whom: every contact is an explicit pair, nothing else is tested.
#pragma once

#include <vector>

#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Name of the plane on which everything stands.
inline constexpr const char* kTableTop = "table_top";

// Writes the pairs: robot with itself, robot with table, and then those of the props.
void add_contact_pairs(Element& root, const std::vector<Prop>& props);

}  // namespace engram::mjcf
