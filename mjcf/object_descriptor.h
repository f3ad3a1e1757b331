// Descriptors of props for the objects observation.
#pragma once

#include "mjcf/prop.h"

namespace engram::mjcf {

// Kind and shape of a prop, and size and colour of its visible geoms.
ObjectDescriptor describe_object(const Prop& prop);

}  // namespace engram::mjcf
