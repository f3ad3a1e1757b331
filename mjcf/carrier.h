// Carriers: constant forces that hold a body's weight in MuJoCo, whose version 2.2 has no gravity
// compensation of its own.
#pragma once

#include <string>

#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

inline constexpr double kGravity = 9.81;  // m/s^2, downwards

// Writes the site of the world's axes, to which all carriers refer.
void add_carrier_frame(Element& worldbody);

// Writes the site at a body's centre of mass on which its carrier acts.
void add_carrier_site(Element& body, const std::string& body_name, const Vec3& center_of_mass);

// Writes the carrier, an actuator whose force is the weight whatever its control is.
void add_carrier(Element& actuators, const std::string& body_name, double mass);

}  // namespace engram::mjcf
