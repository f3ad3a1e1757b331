// How a prop stands on the table when it is upright.
#pragma once

#include "mjcf/prop.h"

namespace engram::mjcf {

// Height of the lowest point of a primitive, in its body's frame.
double lowest_point(const Primitive& primitive);

// Height of the body's origin at which the lowest colliding primitive touches the table.
double standing_height(const Prop& prop);

// How many contacts MuJoCo gives it there.
int standing_contacts(const Prop& prop);

}  // namespace engram::mjcf
