// The Panda's visual geoms: shells, joint caps and panels. They have neither mass nor contacts.
#pragma once

#include "mjcf/panda_spec.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// The finishes, children of the assets.
void add_panda_materials(Element& assets);

// Appends the visible geoms of one link.
void add_visual_geoms(Element& body, Link link);

}  // namespace engram::mjcf
