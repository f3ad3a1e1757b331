// How many props a scene can have, and how small they can be.
#pragma once

#include <vector>

#include "mjcf/prop.h"

namespace engram::mjcf {

// Upper bound of the contacts that exist at once, those of the robot included.
int max_contacts(const std::vector<Prop>& props);

// Throws Error (kInvalidArgument) if there are too many props or contacts, or a dynamic prop is too
// small or too light for physics.
void check_props(const std::vector<Prop>& props);

}  // namespace engram::mjcf
