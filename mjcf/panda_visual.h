// The Panda's looks: shells, joint caps and panels from primitives. They weigh nothing and touch
// nothing.
#pragma once

#include "mjcf/panda.h"

namespace engram::mjcf {

// The finishes, children of the assets.
void add_panda_materials(Element& assets);

// Appends the visible geoms of one link.
void add_visual_geoms(Element& body, Link link);

}  // namespace engram::mjcf
