// Surroundings of the robot: table, ground, lights and their materials.
#pragma once

#include "mjcf/xml.h"

namespace engram::mjcf {

// The plane on which everything stands, in every document. If the table has edges, also its block
// and the ground, for props that roll off.
void add_table_top(Element& worldbody, bool table_ends);

// For rendering: rendering options and materials (children of the root and of the assets), and the
// visible table, ground and lights.
void add_visual_options(Element& root);
void add_materials(Element& assets);
void add_surroundings(Element& worldbody);

}  // namespace engram::mjcf
