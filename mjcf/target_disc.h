// A target painted on the table.
#pragma once

#include <string>

#include "mjcf/prop.h"

namespace engram::mjcf {

// Five concentric discs in alternating colours, the outer one in `rgba`, the next one white. Visual
// only, without contacts. With its origin at height 0.001 m it lies on the table.
Prop target_disc(const std::string& name, double radius, const Rgba& rgba,
                 bool hidden_from_sensors = false);

}  // namespace engram::mjcf
