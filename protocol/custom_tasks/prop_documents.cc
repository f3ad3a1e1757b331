#include "protocol/custom_tasks/prop_documents.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/error.h"
#include "core/base/join.h"
#include "mjcf/ball.h"
#include "mjcf/battery.h"
#include "mjcf/button.h"
#include "mjcf/disc.h"
#include "mjcf/inertia.h"
#include "mjcf/lamp.h"
#include "mjcf/mesh_geom.h"
#include "mjcf/mug.h"
#include "mjcf/object_shapes.h"
#include "mjcf/peg.h"
#include "mjcf/table_contact.h"
#include "mjcf/target_disc.h"
#include "protocol/custom_tasks/keyed_table.h"

namespace engram {
namespace {

using mjcf::BodyType;
using mjcf::Geom;
using mjcf::GeomType;
using mjcf::Prop;
using mjcf::Rgba;

constexpr double kLargest = 2;  // m
constexpr std::size_t kMinPoints = 4;
constexpr std::size_t kMaxPoints = 20'000;
constexpr double kMaxDensity = 1e5;   // kg/m^3
constexpr double kMaxFriction = 100;  // both are far beyond any material
constexpr std::array kBodies = {"dynamic", "kinematic", "visual"};
constexpr std::array kGeomTypes = {"box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"};

double length(const KeyedTable& table, std::string_view key) {
  const double value = table.number(key);
  if (value <= 0 || value > kLargest) {
    table.refuse("'" + std::string(key) + "' has to be a length of 0 to 2 m");
  }
  return value;
}

Rgba rgba_of(const KeyedTable& table, std::string_view key, const std::vector<double>& values) {
  if (!std::ranges::all_of(values, [](double value) { return value >= 0 && value <= 1; })) {
    table.refuse("'" + std::string(key) + "' has to be numbers from 0 to 1");
  }
  return {values[0], values[1], values[2], values.size() > 3 ? values[3] : 1.0};
}

Rgba color(const KeyedTable& table, std::string_view key = "color") {
  if (!table.has(key)) return {1, 1, 1, 1};
  return rgba_of(table, key, table.numbers(key, 3, 4));
}

// --- bodies of geoms ---

// Gives a prop of geoms its body: what moves it, mass and friction.
void set_body(const KeyedTable& table, Prop& prop) {
  const std::size_t body = table.has("body") ? table.choice("body", kBodies) : 0;
  prop.body_type = body == 0 ? BodyType::kDynamic : BodyType::kKinematic;
  if (body == 2) {
    for (Geom& geom : prop.geoms) geom.collides = false;
  }
  prop.pushes_props = table.truth("pushes_props", false);
  prop.friction = table.number("friction", prop.friction);
  if (prop.friction < 0 || prop.friction > kMaxFriction) {
    table.refuse("'friction' has to be from 0 to 100");
  }
  const double density = table.number("density", mjcf::kDensity);
  if (density <= 0 || density > kMaxDensity) {
    table.refuse("'density' has to be above 0, at most 100000 kg/m^3");
  }
  if (body != 0) return;
  for (const Geom& geom : prop.geoms) {
    if (geom.type == GeomType::kCapsule || geom.type == GeomType::kEllipsoid) {
      table.refuse("capsules and ellipsoids are for kinematic and visual props only");
    }
  }
  mjcf::set_solid_inertia(prop, density);
}

// The convex hull of the points under "vertices".
Geom mesh_geom(const KeyedTable& table) {
  const JsonList& list = table.list("vertices");
  if (list.size() < kMinPoints || list.size() > kMaxPoints) {
    table.refuse("'vertices': " + std::to_string(list.size()) + " given, 4 to 20000 allowed");
  }
  std::vector<mjcf::Vec3> points;
  double least = kLargest;
  double greatest = -kLargest;
  for (const Json& one : list) {
    const auto* numbers = std::get_if<JsonList>(&one.value);
    if (numbers == nullptr || numbers->size() != 3 || !std::ranges::all_of(*numbers, is_number)) {
      table.refuse("'vertices' has to be a list of [x, y, z]");
    }
    mjcf::Vec3& point = points.emplace_back();
    std::ranges::transform(*numbers, point.begin(), [](const Json& n) { return number(n); });
    least = std::min(least, std::ranges::min(point));
    greatest = std::max(greatest, std::ranges::max(point));
  }
  const bool in_bounds = std::ranges::all_of(points, [](const mjcf::Vec3& point) {
    return std::ranges::all_of(point, [](double x) { return std::abs(x) <= kLargest; });
  });
  if (!in_bounds) {
    table.refuse("'vertices' reach from " + shortest(least) + " to " + shortest(greatest) +
                 ", -2 to 2 m allowed");
  }
  try {
    return mjcf::mesh_geom(points);
  } catch (const Error& error) {
    table.refuse(std::string("'vertices': ") + error.what());
  }
}

void set_size(const KeyedTable& table, Geom& part) {
  part.size = table.numbers<3>("size");
  const std::size_t sizes = part.type == GeomType::kSphere                                     ? 1
                            : part.type == GeomType::kBox || part.type == GeomType::kEllipsoid ? 3
                                                                                               : 2;
  for (std::size_t i = 0; i < sizes; ++i) {
    if (part.size[i] <= 0 || part.size[i] > kLargest) {
      table.refuse("'size' has to be lengths of 0 to 2 m");
    }
  }
}

Geom geom(const Json& document, const std::string& what) {
  const KeyedTable table(document, what);
  table.allow(std::array{"type", "size", "vertices", "pos", "quat", "color", "collides", "visible",
                         "emission"});
  Geom part;
  part.type = static_cast<GeomType>(table.choice("type", kGeomTypes));
  if (part.type == GeomType::kMesh) {
    part = mesh_geom(table);
  } else {
    set_size(table, part);
  }
  if (table.has("pos")) part.pos = table.numbers<3>("pos");
  if (table.has("quat")) part.quat = table.numbers<4>("quat");
  part.rgba = color(table);
  part.collides = table.truth("collides", true);
  part.visible = table.truth("visible", true);
  part.emission = table.number("emission", 0);
  return part;
}

// --- kinds ---

constexpr std::array kCommon = {"kind", "name", "object", "pos", "quat"};

// Allows the keys of all props, those of a body if it has one, and its own.
template <std::size_t Count>
void allow(const KeyedTable& table, bool has_body, const std::array<const char*, Count>& own) {
  std::vector<const char*> keys(kCommon.begin(), kCommon.end());
  keys.insert(keys.end(), own.begin(), own.end());
  if (has_body) keys.insert(keys.end(), {"body", "density", "friction", "pushes_props"});
  table.allow(keys);
}
void allow(const KeyedTable& table) { table.allow(kCommon); }

Prop of_geom(const KeyedTable& table, const std::string& name, const Geom& part, double height,
             ObjectKind kind, int shape) {
  Prop prop;
  prop.name = name;
  prop.geoms = {part};
  prop.geoms.front().rgba = color(table);
  prop.kind = kind;
  prop.object_shape = shape;
  prop.pos = {0, 0, height};
  set_body(table, prop);
  return prop;
}

Prop cube(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"half_size", "color"});
  return mjcf::cube(name, length(table, "half_size"), color(table));
}

Prop box(const KeyedTable& table, const std::string& name) {
  allow(table, true, std::array{"half_size", "color"});
  const auto half = table.numbers<3>("half_size");
  for (const double side : half) {
    if (side <= 0 || side > kLargest) table.refuse("'half_size' has to be lengths of 0 to 2 m");
  }
  return of_geom(table, name, {.type = GeomType::kBox, .size = half}, half[2], ObjectKind::kObject,
                 static_cast<int>(ObjectShape::kCube));
}

Prop sphere(const KeyedTable& table, const std::string& name) {
  allow(table, true, std::array{"radius", "color"});
  const double radius = length(table, "radius");
  return of_geom(table, name, {.type = GeomType::kSphere, .size = {radius, 0, 0}}, radius,
                 ObjectKind::kObject, static_cast<int>(ObjectShape::kSphere));
}

Prop cylinder(const KeyedTable& table, const std::string& name) {
  allow(table, true, std::array{"radius", "half_height", "color"});
  const double half = length(table, "half_height");
  return of_geom(table, name,
                 {.type = GeomType::kCylinder, .size = {length(table, "radius"), half, 0}}, half,
                 ObjectKind::kObject, static_cast<int>(ObjectShape::kCylinder));
}

Prop mesh(const KeyedTable& table, const std::string& name) {
  allow(table, true, std::array{"vertices", "color"});
  const Geom part = mesh_geom(table);
  return of_geom(table, name, part, -mjcf::lowest_point(part), ObjectKind::kObject, -1);
}

Prop ball(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"radius", "color"});
  return mjcf::ball(name, length(table, "radius"), color(table));
}

Prop shape(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"shape", "color", "scale"});
  std::array<const char*, kObjectShapeNames.size()> names{};
  std::ranges::transform(kObjectShapeNames, names.begin(), [](auto one) { return one.data(); });
  const auto chosen = static_cast<ObjectShape>(table.choice("shape", names));
  const double scale = table.has("scale") ? length(table, "scale") : mjcf::kShapeScale;
  return mjcf::shape_prop(name, chosen, color(table), scale);
}

Prop target_disc(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"radius", "color"});
  return mjcf::target_disc(name, length(table, "radius"), color(table));
}

Prop disc(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"radius", "half_height", "color"});
  return mjcf::disc(name, length(table, "radius"), length(table, "half_height"), color(table));
}

Prop mug(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::mug(name);
}

Prop peg(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"half_length", "half_width", "colors"});
  const JsonList& colors = table.list("colors");
  if (colors.size() != 2) table.refuse("'colors' has to be two colours");
  const auto half = [&](std::size_t i) {
    const Json one = JsonTable{{"color", colors[i]}};
    return color(KeyedTable(one, table.what()));
  };
  return mjcf::peg(name, length(table, "half_length"), length(table, "half_width"), half(0),
                   half(1));
}

Prop battery(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::battery(name);
}

Prop battery_tray(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"slots"});
  std::vector<std::array<double, 2>> slots;
  for (const Json& slot : table.list("slots")) {
    const Json one = JsonTable{{"slot", slot}};
    slots.push_back(KeyedTable(one, table.what()).numbers<2>("slot"));
  }
  return mjcf::battery_tray(name, slots);
}

Prop battery_socket(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::battery_socket(name);
}

Prop button_base(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::button_base(name, {});
}

Prop button_cap(const KeyedTable& table, const std::string& name) {
  allow(table, false, std::array{"travel"});
  return mjcf::button_cap(name, {}, length(table, "travel"));
}

Prop lamp_body(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::lamp_body(name);
}

Prop lamp_bulb(const KeyedTable& table, const std::string& name) {
  allow(table);
  return mjcf::lamp_bulb(name);
}

Prop parts(const KeyedTable& table, const std::string& name) {
  allow(table, true, std::array{"geoms"});
  Prop prop;
  prop.name = name;
  for (const Json& one : table.list("geoms")) {
    prop.geoms.push_back(geom(one, table.what() + ", a geom"));
  }
  if (prop.geoms.empty()) table.refuse("'geoms' has to be a list of at least one");
  prop.kind = ObjectKind::kObject;
  set_body(table, prop);
  return prop;
}

struct PropKind {
  const char* name;
  Prop (*make)(const KeyedTable& table, const std::string& name);
};

constexpr std::array kKinds = {
    PropKind{"cube", cube},
    PropKind{"box", box},
    PropKind{"sphere", sphere},
    PropKind{"cylinder", cylinder},
    PropKind{"mesh", mesh},
    PropKind{"ball", ball},
    PropKind{"shape", shape},
    PropKind{"target_disc", target_disc},
    PropKind{"disc", disc},
    PropKind{"mug", mug},
    PropKind{"peg", peg},
    PropKind{"battery", battery},
    PropKind{"battery_tray", battery_tray},
    PropKind{"battery_socket", battery_socket},
    PropKind{"button_base", button_base},
    PropKind{"button_cap", button_cap},
    PropKind{"lamp_body", lamp_body},
    PropKind{"lamp_bulb", lamp_bulb},
    PropKind{"parts", parts},
};

std::size_t kind_of(const KeyedTable& table) {
  std::array<const char*, kKinds.size()> names{};
  std::ranges::transform(kKinds, names.begin(), &PropKind::name);
  return table.choice("kind", names);
}

// Names of bodies stand in MJCF text.
void check_name(const KeyedTable& table, const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  };
  if (!name.empty() && name.size() <= 60 && std::ranges::all_of(name, allowed)) return;
  table.refuse("'name': '" + name + "' given, letters, digits and _ allowed, at most 60");
}

ObjectKind object_kind(const KeyedTable& table) {
  std::array<const char*, kObjectKindNames.size() + 1> names{};
  names.front() = "part";
  std::ranges::transform(kObjectKindNames, names.begin() + 1, [](auto one) { return one.data(); });
  return static_cast<ObjectKind>(table.choice("object", names));
}

}  // namespace

mjcf::Prop to_prop(const Json& document, const std::string& what) {
  const KeyedTable unnamed(document, what + ", a prop");
  const std::string name = unnamed.text("name");
  const KeyedTable table(document, what + ", prop '" + name + "'");
  check_name(table, name);
  Prop prop = kKinds[kind_of(table)].make(table, name);
  if (table.has("object")) prop.kind = object_kind(table);
  if (table.has("pos")) prop.pos = table.numbers<3>("pos");
  if (table.has("quat")) prop.quat = table.numbers<4>("quat");
  return prop;
}

}  // namespace engram
