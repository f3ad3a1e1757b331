#include "mjcf/prop_body.h"

#include <algorithm>
#include <span>

#include "core/math/display_color.h"
#include "mjcf/shape.h"

namespace engram::mjcf {
namespace {

std::string geom_name(const Prop& prop, std::size_t index) {
  return prop.name + "_" + std::to_string(index);
}

bool glows(const Primitive& primitive) { return primitive.visible && primitive.emission > 0; }

// As pictures show it. Even where a colour has nothing of a channel, faces reflect some light; next
// to what glows that is nothing.
Rgba shown_color(const Primitive& primitive) {
  const double gloss = glows(primitive) ? 0 : 0.0002;
  Rgba shown = primitive.rgba;
  for (std::size_t k = 0; k < 3; ++k) {
    shown[k] = std::min(display_level(primitive.rgba[k] + gloss), 1.0);
  }
  return shown;
}

void add_primitive(Element& body, const Prop& prop, std::size_t index, bool visuals) {
  const Primitive& primitive = prop.primitives[index];
  Element& geom = add_geom(body, primitive.shape, primitive.size, primitive.pos, {});
  set(geom, "name", geom_name(prop, index));
  if (primitive.quat != Quat{1, 0, 0, 0}) set(geom, "quat", primitive.quat);

  const bool shown = visuals && primitive.visible;
  const int visual = primitive.hidden_from_sensors ? kPeopleGroup : kVisualGroup;
  set(geom, "group", shown ? visual : kCollisionGroup);
  if (!shown) return;
  set(geom, "rgba", shown_color(primitive));
  set(geom, "material", glows(primitive) ? geom_name(prop, index) : "prop");
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

void add_prop(Element& worldbody, const Prop& prop, bool visuals) {
  Element& body = add(worldbody, "body");
  set(body, "name", prop.name);
  set(body, "pos", prop.pos);
  set(body, "quat", prop.quat);
  if (prop.motion == Motion::kKinematic) {
    set(body, "mocap", "true");
  } else {
    add_free_joint(body, prop);
    Element& inertial = add(body, "inertial");
    set(inertial, "mass", prop.mass);
    set(inertial, "pos", prop.center_of_mass);
    set(inertial, "fullinertia", prop.inertia);
  }
  for (std::size_t i = 0; i < prop.primitives.size(); ++i) {
    const Primitive& primitive = prop.primitives[i];
    if (primitive.collides || (visuals && primitive.visible)) add_primitive(body, prop, i, visuals);
  }
}

void add_prop_materials(Element& assets, const Prop& prop) {
  for (std::size_t i = 0; i < prop.primitives.size(); ++i) {
    if (!glows(prop.primitives[i])) continue;
    Element& material = add(assets, "material");
    set(material, "name", geom_name(prop, i));
    set(material, "emission", prop.primitives[i].emission);
    set(material, "specular", 0.0);
  }
}

std::vector<std::string> collision_geom_names(const Prop& prop) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < prop.primitives.size(); ++i) {
    if (prop.primitives[i].collides) names.push_back(geom_name(prop, i));
  }
  return names;
}

}  // namespace engram::mjcf
