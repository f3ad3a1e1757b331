// The geom element of MJCF.
#pragma once

#include <string>

#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Geom groups: MuJoCo's viewers show 0 to 2 by default.
inline constexpr int kPeopleGroup = 1;  // seen by people, not by the robot's sensors
inline constexpr int kVisualGroup = 2;
inline constexpr int kCollisionGroup = 3;

// MJCF's name of a type, and the number of its sizes that count.
const char* geom_type(GeomType type);
int size_count(GeomType type);

// Appends a geom posed by a position and fixed-axis angles (radians; see the compiler's eulerseq).
Element& add_geom(Element& body, GeomType type, const Vec3& size, const Vec3& pos, const Vec3& rpy);

// Appends a capsule or cylinder whose axis runs from one point to another.
Element& add_fromto_geom(Element& body, GeomType type, const Vec3& from, const Vec3& to,
                         double radius);

}  // namespace engram::mjcf
