#include "mjcf/prop_body.h"

#include <algorithm>
#include <span>

#include "core/math/display_color.h"
#include "mjcf/geom_element.h"
#include "mjcf/mesh_geom.h"

namespace engram::mjcf {
namespace {

std::string geom_name(const Prop& prop, std::size_t index) {
  return prop.name + "_" + std::to_string(index);
}

bool is_emissive(const Geom& geom) { return geom.visible && geom.emission > 0; }

// Displayed colour. Even without a colour's channel, faces reflect some of its light; next to an
// emissive geom that is negligible.
Rgba shown_color(const Geom& geom) {
  const double gloss = is_emissive(geom) ? 0 : 0.0002;
  Rgba shown = geom.rgba;
  for (std::size_t k = 0; k < 3; ++k) {
    shown[k] = std::min(display_level(geom.rgba[k] + gloss), 1.0);
  }
  return shown;
}

void add_geom_of(const Prop& prop, std::size_t index, bool visuals, Element& body) {
  const Geom& geom = prop.geoms[index];
  Element& element = add_geom(body, geom.type, geom.size, geom.pos, {});
  set(element, "name", geom_name(prop, index));
  if (geom.type == GeomType::kMesh) set(element, "mesh", geom_name(prop, index));
  const auto [w, x, y, z] = geom.quat;
  set_rotation(element, Eigen::Quaterniond(w, x, y, z));

  const bool shown = visuals && geom.visible;
  const int visual = geom.hidden_from_sensors ? kPeopleGroup : kVisualGroup;
  set(element, "group", shown ? visual : kCollisionGroup);
  if (!shown) return;
  set(element, "rgba", shown_color(geom));
  set(element, "material", is_emissive(geom) ? geom_name(prop, index) : "prop");
}

void add_free_joint(Element& body, const Prop& prop) {
  if (prop.damping == 0) {
    set(add(body, "freejoint"), "name", prop.name);
    return;
  }
  Element& joint = add(body, "joint");
  set(joint, "name", prop.name);
  set(joint, "type", "free");
  set(joint, "damping", prop.damping);
}

}  // namespace

Element& add_prop(Element& worldbody, const Prop& prop, bool visuals) {
  Element& body = add(worldbody, "body");
  set(body, "name", prop.name);
  set(body, "pos", prop.pos);
  const auto [w, x, y, z] = prop.quat;
  set_rotation(body, Eigen::Quaterniond(w, x, y, z));
  if (prop.body_type == BodyType::kKinematic) {
    set(body, "mocap", "true");
  } else {
    add_free_joint(body, prop);
    add_inertial(body, prop.mass, prop.center_of_mass, prop.inertia);
  }
  for (std::size_t i = 0; i < prop.geoms.size(); ++i) {
    const Geom& geom = prop.geoms[i];
    if (geom.collides || (visuals && geom.visible)) add_geom_of(prop, i, visuals, body);
  }
  return body;
}

void add_prop_materials(Element& assets, const Prop& prop) {
  for (std::size_t i = 0; i < prop.geoms.size(); ++i) {
    if (!is_emissive(prop.geoms[i])) continue;
    Element& material = add(assets, "material");
    set(material, "name", geom_name(prop, i));
    set(material, "emission", prop.geoms[i].emission);
    set(material, "specular", 0.0);
  }
}

bool has_mesh(const Prop& prop) {
  return std::ranges::any_of(prop.geoms,
                             [](const Geom& geom) { return geom.type == GeomType::kMesh; });
}

void add_prop_meshes(Element& assets, const Prop& prop) {
  for (std::size_t i = 0; i < prop.geoms.size(); ++i) {
    const Geom& geom = prop.geoms[i];
    if (geom.type != GeomType::kMesh) continue;
    Element& mesh = add(assets, "mesh");
    set(mesh, "name", geom_name(prop, i));
    const ConvexHull hull = hull_of(geom);
    std::vector<double> vertices;
    for (const auto& corner : hull.corners) {
      vertices.insert(vertices.end(), corner.begin(), corner.end());
    }
    set(mesh, "vertex", vertices);
    const std::vector<int> triangles = triangles_of(hull);
    set(mesh, "face", std::vector<double>(triangles.begin(), triangles.end()));
  }
}

std::vector<std::string> collision_geom_names(const Prop& prop) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < prop.geoms.size(); ++i) {
    if (prop.geoms[i].collides) names.push_back(geom_name(prop, i));
  }
  return names;
}

}  // namespace engram::mjcf
