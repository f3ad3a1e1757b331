#include "mjcf/scenery.h"

#include "core/math/real_functions.h"
#include "mjcf/contact_pairs.h"
#include "mjcf/geom_element.h"

namespace engram::mjcf {
namespace {

// The table's block and the ground.
constexpr double kGroundHeight = -0.91964;
constexpr Vec3 kTableHalfSize = {0.6045, 1.209, 0.45982145};
constexpr Vec3 kTableCenter = {-0.12, 0, -0.45982145};
// The visible board. Its near edge is 16 mm behind the block's, as the original's mesh has it.
constexpr Vec3 kBoardHalfSize = {0.5967, 1.209, 0.015};
constexpr Vec3 kBoardCenter = {-0.1278, 0, -0.0155};

// The original benchmark's lights. Its pipeline shades linearly, divides by pi and encodes for the
// display with a power of 1 / 2.2. A power of a product is the product of the powers, so we light
// encoded colours with encoded light. MuJoCo adds up lights, though, which a power does not allow.
// These levels are exact where it matters most: in the dark (0.3 -> 0.5785), on upright faces
// turned to light 1 (0.484 -> 0.719), and facing up (0.802 -> 0.9045).
constexpr double kAmbient = 0.580;
constexpr double kSlanted = 0.2397;
constexpr double kOverhead = 0.1875;

Vec3 normalized(const Vec3& v) {
  const double norm = real::hypot(v[0], v[1], v[2]);
  return {v[0] / norm, v[1] / norm, v[2] / norm};
}

void add_light(Element& world, const char* name, const Vec3& direction, double level) {
  Element& light = add(world, "light");
  set(light, "name", name);
  set(light, "directional", "true");
  set(light, "castshadow", "false");
  set(light, "pos", {0, 0, 3});
  set(light, "dir", normalized(direction));
  set(light, "diffuse", {level, level, level});
  set(light, "specular", {0.1, 0.1, 0.1});
}

Element& add_material(Element& assets, const char* name, double specular) {
  Element& material = add(assets, "material");
  set(material, "name", name);
  set(material, "specular", specular);
  return material;
}

// Wood: the colour that renderers spread grain about. No texture of MuJoCo's: its dots come from
// the process's rand(), so that a scene's colours would depend on what other threads do.
void add_wood(Element& assets) {
  Element& material = add_material(assets, "wood", 0.3);
  set(material, "rgba", {0.62, 0.3708, 0.2322, 1});
}

// Ground: a line every metre.
void add_tiles(Element& assets) {
  Element& texture = add(assets, "texture");
  set(texture, "name", "tiles");
  set(texture, "type", "2d");
  set(texture, "builtin", "flat");
  set(texture, "width", 256);
  set(texture, "height", 256);
  set(texture, "rgb1", {0.4645, 0.482, 0.517});
  set(texture, "mark", "edge");
  set(texture, "markrgb", {0.66, 0.67, 0.68});
  Element& material = add_material(assets, "tiles", 0);
  set(material, "texture", "tiles");
  set(material, "texuniform", "true");
  set(material, "texrepeat", {1, 1});
}

}  // namespace

void add_table_top(Element& worldbody, bool table_ends) {
  Element& plane = add(worldbody, "geom");
  set(plane, "name", kTableTop);
  set(plane, "type", "plane");
  set(plane, "size", {0, 0, 1});
  set(plane, "group", kCollisionGroup);
  if (!table_ends) return;

  Element& block = add_geom(worldbody, GeomType::kBox, kTableHalfSize, kTableCenter, {});
  set(block, "name", kTableBlock);
  set(block, "group", kCollisionGroup);
  Element& ground = add(worldbody, "geom");
  set(ground, "name", kGround);
  set(ground, "type", "plane");
  set(ground, "size", {0, 0, 1});
  set(ground, "pos", {0, 0, kGroundHeight});
  set(ground, "group", kCollisionGroup);
}

void add_visual_options(Element& root) {
  Element& visual = add(root, "visual");
  Element& headlight = add(visual, "headlight");
  set(headlight, "ambient", {kAmbient, kAmbient, kAmbient});
  set(headlight, "diffuse", {0, 0, 0});
  set(headlight, "specular", {0, 0, 0});

  // Near and far planes, in units of the statistic's extent (1 m).
  Element& map = add(visual, "map");
  set(map, "znear", 0.01);
  set(map, "zfar", 100.0);

  Element& buffer = add(visual, "global");
  set(buffer, "offwidth", 1024);
  set(buffer, "offheight", 1024);
}

void add_materials(Element& assets) {
  add_wood(assets);
  add_tiles(assets);
  add_material(assets, "prop", 0);
}

void add_surroundings(Element& worldbody) {
  add_light(worldbody, "slanted", {1, 1, -1}, kSlanted);
  add_light(worldbody, "overhead", {0, 0, -1}, kOverhead);

  // The visible table is a board with the floor below it, and ends a hair below the contacts' top,
  // so that flat things on it do not flicker.
  Element& table = add_geom(worldbody, GeomType::kBox, kBoardHalfSize, kBoardCenter, {});
  set(table, "name", "table");
  set(table, "group", kVisualGroup);
  set(table, "material", "wood");

  Element& ground = add(worldbody, "geom");
  set(ground, "name", "ground");
  set(ground, "type", "plane");
  set(ground, "size", {50, 50, 1});
  set(ground, "pos", {0, 0, kGroundHeight});
  set(ground, "group", kVisualGroup);
  set(ground, "material", "tiles");
}

}  // namespace engram::mjcf
