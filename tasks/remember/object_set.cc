#include "tasks/remember/object_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "tasks/common/colors.h"
#include "tasks/common/layout.h"
#include "tasks/common/words.h"

namespace engram::tasks {
namespace {

using mjcf::ObjectShape;
using mjcf::shape_name;

constexpr std::array<int, 4> COLOR = {0, 0, 255, 255};

std::array<const char*, mjcf::kObjectShapeCount> shape_names() {
  std::array<const char*, mjcf::kObjectShapeCount> names{};
  for (std::size_t i = 0; i < names.size(); ++i) {
    names[i] = shape_name(static_cast<ObjectShape>(i)).data();
  }
  return names;
}

std::string object_name(std::string_view shape, int key) {
  return std::string(shape) + "_" + std::to_string(key);
}

ConstantTable shape_table(const NameList& shapes) {
  ConstantTable table;
  for (int i = 0; i < shapes.size(); ++i) {
    table.emplace_back(std::to_string(i),
                       std::string(shape_name(static_cast<ObjectShape>(shapes[i]))));
  }
  return table;
}

}  // namespace

// --- constants ---

void ObjectSetParams::declare(ConstantBinder& constants, bool spreads) {
  constexpr Bounds kSize{0.01, 0.035};
  constexpr double kMax = Layout::kCapacity;
  constexpr double kMinDistance = SpreadParams{}.MANIP_MIN_DISTANCE;
  const auto names = shape_names();
  switch (vocabulary) {
    case Vocabulary::kColor:
      constants.integer("COLORS", count, {2, COLOR_MAPPING.size()}, "",
                        "cubes, in the first colours of the colour table");
      constants.fixed({{"COLOR_MAPPING", color_mapping_constant()}});
      constants.real("CUBE_HALFSIZE", size, kSize, "m", "half the side of a cube");
      if (spreads) constants.fixed({{"MANIP_MIN_CUBE_DISTANCE", kMinDistance}});
      return;
    case Vocabulary::kShape:
      constants.integer("SHAPES", count, {2, mjcf::kObjectShapeCount}, "",
                        "objects, of the first shapes");
      constants.names("SHAPE_MAPPING", shapes, names, 2, "which shapes there are, in order",
                      shape_table);
      constants.fixed({{"COLOR", ConstantList(COLOR.begin(), COLOR.end())}});
      if (spreads) constants.fixed({{"MANIP_MIN_SHAPE_DISTANCE", kMinDistance}});
      break;
    case Vocabulary::kShapeAndColor:
      constants.integer("SHAPES", count, {2, kMax}, "",
                        "objects, of the first combinations: all colours of a shape, then "
                        "the next shape");
      constants.names("BASE_SHAPES", shapes, names, 1, "shapes that are combined with colours",
                      shape_table);
      constants.colors("COLOR_PALETTE", COLOR_PALETTE, 1, "colours that shapes are combined with");
      if (spreads) constants.fixed({{"MANIP_MIN_DISTANCE", kMinDistance}});
      break;
  }
  constants.real("SHAPE_SCALE", size, kSize, "m", "half the side of the cube; the others follow");
}

void ObjectSetParams::check() const {
  if (vocabulary == Vocabulary::kColor) return;
  const bool colored = vocabulary == Vocabulary::kShapeAndColor;
  const int most = shapes.size() * (colored ? COLOR_PALETTE.size() : 1);
  if (count <= most) return;
  const std::string kinds = colored ? std::to_string(shapes.size()) + " shapes x " +
                                          std::to_string(COLOR_PALETTE.size()) +
                                          " colours = " + std::to_string(most)
                                    : std::to_string(most) + " shapes";
  refuse_constant("SHAPES", std::to_string(count), "at most " + kinds + " allowed");
}

// --- the objects ---

ObjectSet::ObjectSet(const ObjectSetParams& params) : params_(params) {
  switch (params.vocabulary) {
    case Vocabulary::kColor:
      add_cubes();
      break;
    case Vocabulary::kShape:
      add_shapes();
      break;
    case Vocabulary::kShapeAndColor:
      add_colored_shapes();
      break;
  }
}

void ObjectSet::add(mjcf::Prop prop, std::vector<int> identity, const ObjectLabel& label) {
  Footprint footprint = footprint_of(prop);
  objects_.push_back({std::move(prop), std::move(identity), label, std::move(footprint)});
}

void ObjectSet::add_cubes() {
  for (int key = 0; key < params_.count; ++key) {
    const mjcf::Rgba color = to_rgba(COLOR_MAPPING[at(key)].rgba);
    add(mjcf::cube(object_name("cube", key), params_.size, color), {key},
        {.has_color = true, .color = color, .shape = {}});
  }
}

void ObjectSet::add_shapes() {
  for (int key = 0; key < params_.count; ++key) {
    const auto shape = static_cast<ObjectShape>(params_.shapes[key]);
    const std::string_view name = shape_name(shape);
    add(mjcf::shape_prop(object_name(name, key), shape, to_rgba(COLOR), params_.size), {key},
        {.has_color = false, .color = {}, .shape = name});
  }
}

// All colours of a shape before the next shape.
void ObjectSet::add_colored_shapes() {
  const ColorList& palette = params_.COLOR_PALETTE;
  for (int key = 0; key < params_.count; ++key) {
    const int shape_id = key / palette.size();
    const int color_id = key % palette.size();
    const auto shape = static_cast<ObjectShape>(params_.shapes[shape_id]);
    const mjcf::Rgba& color = palette[color_id];
    const std::string_view name = shape_name(shape);
    add(mjcf::shape_prop(object_name(name, key), shape, color, params_.size), {shape_id, color_id},
        {.has_color = true, .color = color, .shape = name});
  }
}

std::string ObjectSet::name(int key) const {
  return name_object(prop(key), {.color = vocabulary() != Vocabulary::kShape,
                                 .shape = vocabulary() != Vocabulary::kColor});
}

double ObjectSet::greatest_width() const {
  double radius = 0;
  for (const Object& one : objects_) radius = std::max(radius, one.footprint.radius);
  return 2 * radius;
}

void ObjectSet::overlay(int key, Overlay& out) const {
  constexpr double kSwatchLeft = 130;  // right of "Target:"
  constexpr double kNameGap = 8;
  constexpr double kBaseline = 60;
  constexpr OverlaySwatch kSwatch{{kSwatchLeft, 38}, 22, {}};
  const ObjectLabel& label = object(key).label;
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
