// The Panda's collision geometry: few primitives, close to the real arm.
#pragma once

#include <string>

#include "mjcf/panda.h"

namespace engram::mjcf {

// Appends the collision geoms of one link.
void add_collision_geoms(Element& body, Link link);

// How many geoms a link has, and their names: "<link>_collision_<i>".
int collision_geom_count(Link link);
std::string collision_geom_name(Link link, int index);

}  // namespace engram::mjcf
