#include "tasks/remember/object_set.h"

#include <array>
#include <cmath>
#include <string>

#include "mjcf/shapes.h"
#include "tasks/parts/colors.h"

namespace engram::tasks {
namespace {

using mjcf::ObjectShape;
using mjcf::shape_name;

constexpr double CUBE_HALFSIZE = 0.02;  // m
constexpr double SHAPE_SCALE = 0.02;    // m
constexpr std::array<int, 4> COLOR = {0, 0, 255, 255};
constexpr std::array<ObjectShape, 5> BASE_SHAPES = {ObjectShape::kCube, ObjectShape::kSphere,
                                                    ObjectShape::kTShape, ObjectShape::kCross,
                                                    ObjectShape::kTorus};
constexpr std::array<mjcf::Rgba, 3> COLOR_PALETTE = {
    {{1, 0, 0, 1}, {0, 1, 0, 1}, {0, 0, 1, 1}}};  // red, green, blue
constexpr int kPaletteSize = static_cast<int>(COLOR_PALETTE.size());

constexpr SmoothnessParams kSmooth = {
    .ACTION_L2_COEF = 0.02, .ACTION_DELTA_L2_COEF = 0.05, .QVEL_L2_COEF = 0.01};

std::string object_name(std::string_view shape, int key) {
  return std::string(shape) + "_" + std::to_string(key);
}

template <class Shapes>
ConstantTable shape_table(const Shapes& shapes) {
  ConstantTable table;
  for (const ObjectShape shape : shapes) {
    table.emplace_back(std::to_string(table.size()), std::string(shape_name(shape)));
  }
  return table;
}

ConstantTable palette_table() {
  ConstantTable table;
  for (const mjcf::Rgba& color : COLOR_PALETTE) {
    table.emplace_back(std::to_string(table.size()), ConstantList(color.begin(), color.end()));
  }
  return table;
}

}  // namespace

ObjectSet::ObjectSet(Vocabulary vocabulary, int count) {
  switch (vocabulary) {
    case Vocabulary::kColor:
      add_cubes(count);
      smoothness_ = kSmooth;
      break;
    case Vocabulary::kShape:
      add_shapes(count);
      smoothness_ = kSmooth;
      break;
    case Vocabulary::kShapeAndColor:
      add_colored_shapes(count);
      break;
  }
}

void ObjectSet::add(mjcf::Prop prop, std::vector<int> identity, const ObjectLabel& label) {
  Footprint footprint = footprint_of(prop);
  objects_.push_back({std::move(prop), std::move(identity), label, std::move(footprint)});
}

void ObjectSet::add_cubes(int count) {
  for (int key = 0; key < count; ++key) {
    const mjcf::Rgba color = to_rgba(COLOR_MAPPING[static_cast<std::size_t>(key)].rgba);
    add(mjcf::cube(object_name("cube", key), CUBE_HALFSIZE, color), {key},
        {.has_color = true, .color = color, .shape = {}});
  }
  constants_ = {{"COLORS", count},
                {"COLOR_MAPPING", color_mapping_constant()},
                {"CUBE_HALFSIZE", CUBE_HALFSIZE},
                {"MANIP_MIN_CUBE_DISTANCE", SpreadParams{}.MANIP_MIN_DISTANCE}};
}

void ObjectSet::add_shapes(int count) {
  std::array<ObjectShape, mjcf::kObjectShapeCount> all{};
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<ObjectShape>(i);
  for (int key = 0; key < count; ++key) {
    const ObjectShape shape = all[static_cast<std::size_t>(key)];
    const std::string_view name = shape_name(shape);
    add(mjcf::shape_prop(object_name(name, key), shape, to_rgba(COLOR)), {key},
        {.has_color = false, .color = {}, .shape = name});
  }
  constants_ = {{"SHAPES", count},
                {"SHAPE_MAPPING", shape_table(all)},
                {"COLOR", ConstantList(COLOR.begin(), COLOR.end())},
                {"SHAPE_SCALE", SHAPE_SCALE},
                {"MANIP_MIN_SHAPE_DISTANCE", SpreadParams{}.MANIP_MIN_DISTANCE}};
}

// All three colours of a shape before the next shape
void ObjectSet::add_colored_shapes(int count) {
  for (int key = 0; key < count; ++key) {
    const int shape_id = key / kPaletteSize;
    const int color_id = key % kPaletteSize;
    const ObjectShape shape = BASE_SHAPES[static_cast<std::size_t>(shape_id)];
    const mjcf::Rgba& color = COLOR_PALETTE[static_cast<std::size_t>(color_id)];
    const std::string_view name = shape_name(shape);
    add(mjcf::shape_prop(object_name(name, key), shape, color), {shape_id, color_id},
        {.has_color = true, .color = color, .shape = name});
  }
  constants_ = {{"SHAPES", count},
                {"BASE_SHAPES", shape_table(BASE_SHAPES)},
                {"COLOR_PALETTE", palette_table()},
                {"SHAPE_SCALE", SHAPE_SCALE},
                {"MANIP_MIN_DISTANCE", SpreadParams{}.MANIP_MIN_DISTANCE}};
}

void ObjectSet::overlay(int key, Overlay& out) const {
  constexpr double kSwatchLeft = 130;  // right of "Target:"
  constexpr double kNameGap = 8;
  constexpr double kBaseline = 60;
  constexpr OverlaySwatch kSwatch{{kSwatchLeft, 38}, 22, {}};
  const ObjectLabel& label = at(key).label;
  const std::string name(label.shape);
  if (!label.has_color) {
    out.add(OverlayText{{10, kBaseline}, "Target: " + name});
    return;
  }
  const auto byte = [&label](std::size_t i) {
    return static_cast<std::uint8_t>(std::lround(255 * label.color[i]));
  };
  out.add(OverlayText{{10, kBaseline}, "Target:"});
  OverlaySwatch swatch = kSwatch;
  swatch.color = {byte(0), byte(1), byte(2)};
  out.add(swatch);
  if (!name.empty()) {
    out.add(OverlayText{{kSwatchLeft + swatch.size + kNameGap, kBaseline}, name});
  }
}

}  // namespace engram::tasks
