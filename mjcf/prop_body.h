// A prop as a body of the document.
#pragma once

#include <string>
#include <vector>

#include "mjcf/prop.h"
#include "mjcf/xml.h"

namespace engram::mjcf {

// Writes the prop's body and returns it; geoms are named after the geom's index. Without visuals
// only the colliding geoms are written.
Element& add_prop(Element& worldbody, const Prop& prop, bool visuals);

// Materials for the emissive geoms of a prop, children of the assets.
void add_prop_materials(Element& assets, const Prop& prop);

// Meshes of a prop, children of the assets; has_mesh: whether there are any.
void add_prop_meshes(Element& assets, const Prop& prop);
bool has_mesh(const Prop& prop);

// Names of the colliding geoms, in order: "<prop>_<geom>".
std::vector<std::string> collision_geom_names(const Prop& prop);

}  // namespace engram::mjcf
