// A ball that rolls.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// A solid ball of density 1000 kg/m^3, resting on the table. It has no rolling resistance; its spin
// fades by 5 % per second.
Prop ball(const std::string& name, double radius, const Rgba& rgba);

}  // namespace engram::mjcf
