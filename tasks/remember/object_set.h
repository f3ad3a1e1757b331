// The objects of the Remember and Find-Imposter families. A key stands for the same shape and
// colour in every episode.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/index.h"
#include "core/image/overlay.h"
#include "mjcf/object_shapes.h"
#include "mjcf/prop.h"
#include "tasks/common/colors.h"
#include "tasks/common/constant_binder.h"
#include "tasks/common/footprint.h"

namespace engram::tasks {

// Properties that tell objects apart.
enum class Vocabulary {
  kColor,          // cubes in nine colours
  kShape,          // nine blue shapes
  kShapeAndColor,  // five shapes in three colours each
};

// All nine shapes, or the five that are combined with colours.
constexpr NameList default_shapes(Vocabulary vocabulary) {
  if (vocabulary != Vocabulary::kShapeAndColor) return NameList(mjcf::kObjectShapeCount);
  NameList shapes;
  for (const auto shape :
       {mjcf::ObjectShape::kCube, mjcf::ObjectShape::kSphere, mjcf::ObjectShape::kTShape,
        mjcf::ObjectShape::kCross, mjcf::ObjectShape::kTorus}) {
    shapes.push_back(static_cast<int>(shape));
  }
  return shapes;
}

// Choice of objects.
struct ObjectSetParams {
  Vocabulary vocabulary;
  int count;                                     // COLORS or SHAPES: keys 0, ..., count - 1
  double size = mjcf::kShapeScale;               // m: CUBE_HALFSIZE or SHAPE_SCALE
  NameList shapes = default_shapes(vocabulary);  // SHAPE_MAPPING or BASE_SHAPES, by shape
  ColorList COLOR_PALETTE = ColorList(3);        // red, green, blue

  // spreads: three objects are spread, at a distance that is a constant, too.
  void declare(ConstantBinder& constants, bool spreads);
  // Throws Error if there are fewer shapes, or combinations, than objects.
  void check() const;
};

// An object as the overlay names it; what all objects of the set share is left out.
struct ObjectLabel {
  bool has_color = false;
  mjcf::Rgba color{};
  std::string_view shape;
};

class ObjectSet {
 public:
  explicit ObjectSet(const ObjectSetParams& params);

  int count() const { return static_cast<int>(objects_.size()); }
  Vocabulary vocabulary() const { return params_.vocabulary; }
  const mjcf::Prop& prop(int key) const { return object(key).prop; }
  // Nominal orientation.
  const double* quat(int key) const { return object(key).prop.quat.data(); }
  // Half the side of a cube as large as the objects, m.
  double size() const { return params_.size; }
  // Height of the origin of an object that rests on the table, m.
  double resting_height(int key) const { return object(key).prop.pos[2]; }
  // oracle_info: the key, or the ids of shape and colour.
  std::span<const int> identity(int key) const { return object(key).identity; }
  // "red cube", "cross", "green T shape".
  std::string name(int key) const;
  // True if a push makes it roll.
  bool rolls(int key) const {
    const std::vector<mjcf::Geom>& parts = prop(key).geoms;
    return parts.size() == 1 && parts[0].type == mjcf::GeomType::kSphere;
  }
  double clearance(int first, int second, const Vec2& offset) const {
    return tasks::clearance(object(first).footprint, object(second).footprint, offset);
  }
  // The gap between two keys, for the guard against overlaps.
  auto gaps() const {
    return [this](std::size_t first, std::size_t second, const Vec2& offset) {
      return clearance(static_cast<int>(first), static_cast<int>(second), offset);
    };
  }
  double greatest_width() const;  // m
  // Writes "Target:" and the object's label over an image.
  void overlay(int key, Overlay& out) const;

 private:
  struct Object {
    mjcf::Prop prop;  // at rest at the origin
    std::vector<int> identity;
    ObjectLabel label;
    Footprint footprint;
  };

  const Object& object(int key) const { return objects_[at(key)]; }
  void add(mjcf::Prop prop, std::vector<int> identity, const ObjectLabel& label);
  void add_cubes();
  void add_shapes();
  void add_colored_shapes();

  ObjectSetParams params_;
  std::vector<Object> objects_;
};

}  // namespace engram::tasks
