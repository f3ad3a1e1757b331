// A peg of two colours.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// A solid bar of density 1000 kg/m^3 that lies on the table along x. It collides as one box; its
// halves, towards -x and +x, have a colour each.
Prop peg(const std::string& name, double half_length, double half_width, const Rgba& negative_half,
         const Rgba& positive_half);

}  // namespace engram::mjcf
