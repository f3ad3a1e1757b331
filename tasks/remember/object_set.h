// The objects of the Remember and Find-Imposter families. A key stands for the
// same shape and colour in every episode.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "core/base/constant.h"
#include "core/picture/overlay.h"
#include "mjcf/prop.h"
#include "tasks/parts/footprint.h"
#include "tasks/parts/smoothness.h"

namespace engram::tasks {

// What tells objects apart.
enum class Vocabulary {
  kColor,          // cubes in nine colours
  kShape,          // nine blue shapes
  kShapeAndColor,  // five shapes in three colours each
};

// An object as the overlay names it; what all objects of the set share is left out.
struct ObjectLabel {
  bool has_color = false;
  mjcf::Rgba color{};
  std::string_view shape;
};

class ObjectSet {
 public:
  // The objects of keys 0, ..., count - 1.
  ObjectSet(Vocabulary vocabulary, int count);

  int count() const { return static_cast<int>(objects_.size()); }
  const mjcf::Prop& prop(int key) const { return at(key).prop; }
  // Nominal orientation.
  const double* quat(int key) const { return at(key).prop.quat.data(); }
  // Height of the origin of an object that rests on the table, m.
  double resting_height(int key) const { return at(key).prop.pos[2]; }
  // oracle_info: the key, or the ids of shape and colour.
  std::span<const int> identity(int key) const { return at(key).identity; }
  // Whether a push makes it roll.
  bool rolls(int key) const {
    const std::vector<mjcf::Primitive>& parts = prop(key).primitives;
    return parts.size() == 1 && parts[0].shape == mjcf::Shape::kSphere;
  }
  double clearance(int first, int second, const Vec2& offset) const {
    return tasks::clearance(at(first).footprint, at(second).footprint, offset);
  }
  // Writes "Target:" and the object's label over a picture.
  void overlay(int key, Overlay& out) const;

  // The class constants in which the vocabularies differ.
  const ConstantTable& constants() const { return constants_; }
  const SmoothnessParams& smoothness() const { return smoothness_; }

 private:
  struct Object {
    mjcf::Prop prop;  // at rest at the origin
    std::vector<int> identity;
    ObjectLabel label;
    Footprint footprint;
  };

  const Object& at(int key) const { return objects_[static_cast<std::size_t>(key)]; }
  void add(mjcf::Prop prop, std::vector<int> identity, const ObjectLabel& label);
  void add_cubes(int count);
  void add_shapes(int count);
  void add_colored_shapes(int count);

  std::vector<Object> objects_;
  ConstantTable constants_;
  SmoothnessParams smoothness_;
};

}  // namespace engram::tasks
