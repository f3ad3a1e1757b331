// The lamp: a bulb on a small stand, the same in every family that has one. It does not collide.
// Bulb and stand are two props, so that a task can colour the bulb alone.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// The stand. Its origin, and the bulb's, is the middle of its underside.
Prop lamp_body(const std::string& name);

// The bulb, in the stand's frame; white and unlit until a task paints it.
Prop lamp_bulb(const std::string& name);

}  // namespace engram::mjcf
