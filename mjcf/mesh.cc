#include "mjcf/mesh.h"

#include "mjcf/inertia.h"
#include "mjcf/mesh_geom.h"
#include "mjcf/table_contact.h"

namespace engram::mjcf {

Prop mesh(const std::string& name, std::span<const Vec3> points, const Rgba& rgba) {
  Prop prop;
  prop.name = name;
  prop.geoms = {mesh_geom(points)};
  prop.geoms[0].rgba = rgba;
  prop.kind = ObjectKind::kObject;
  prop.pos = {0, 0, height_on_table(prop)};
  set_solid_inertia(prop);
  return prop;
}

}  // namespace engram::mjcf
