// Contact of an upright prop with the table: its height there and its contact points.
#pragma once

#include "mjcf/prop.h"

namespace engram::mjcf {

// Height of the lowest point of a geom, in its body's frame.
double lowest_point(const Geom& geom);

// Height of the body's origin at which the lowest colliding geom touches the table.
double height_on_table(const Prop& prop);

// Number of contacts that MuJoCo finds there.
int table_contact_count(const Prop& prop);

}  // namespace engram::mjcf
