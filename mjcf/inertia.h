// Mass properties of props that are made of solid geoms.
#pragma once

#include "mjcf/prop.h"

namespace engram::mjcf {

// Gives a prop the mass, centre of mass and inertia of its geoms (boxes, spheres,
// cylinders and meshes), all of them solid. Where two overlap, both count, as in PhysX.
void set_solid_inertia(Prop& prop, double density = kDensity);

}  // namespace engram::mjcf
