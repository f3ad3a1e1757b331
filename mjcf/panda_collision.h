// The Panda's collision geometry: few geoms, close to the real arm.
#pragma once

#include <string>

#include "mjcf/panda_spec.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Appends the collision geoms of one link.
void add_collision_geoms(Element& body, Link link);

// Number of geoms of a link, and their names: "<link>_collision_<i>".
int collision_geom_count(Link link);
std::string collision_geom_name(Link link, int index);

}  // namespace engram::mjcf
