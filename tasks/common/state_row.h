// A row of the state observation: every field is declared beside its value. One list serves twice:
// FieldLister reads the names, RowWriter the values.
//
//   template <class Row>
//   void state_row(Row& row, int env) const {
//     row.field("cube_pos", 3, "m", "of the cube", [&] { return state.prop_pos_of(env, kCube); });
//   }
#pragma once

#include <Eigen/Dense>
#include <array>
#include <cassert>
#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/field.h"
#include "tasks/common/poses.h"

namespace engram::tasks {

// A name with a number in it, spelt only where the name is needed: {"goal_", 2, "_pose"}.
struct NumberedName {
  const char* before;
  int number;
  const char* after;

  operator std::string() const {  // NOLINT: it stands where names stand
    return before + std::to_string(number) + after;
  }
};

// Reads the fields of a row; values are not asked for.
class FieldLister {
 public:
  template <class Name, class Value>
  void field(const Name& name, int width, std::string_view unit, std::string_view description,
             const Value& /*value*/) {
    fields_.push_back(
        {std::string(name), width, DType::kFloat32, std::string(unit), std::string(description)});
  }

  std::vector<Field> take() { return std::move(fields_); }

 private:
  std::vector<Field> fields_;
};

// Fills a row of floats from the simulation's doubles, from left to right.
class RowWriter {
 public:
  explicit RowWriter(float* out) : out_(out) {}

  // `value` gives a number, a vector, a pose or the address of `width` numbers; or it takes this
  // writer and adds `width` numbers itself.
  template <class Name, class Value>
  void field(const Name& /*name*/, int width, std::string_view /*unit*/,
             std::string_view /*description*/, const Value& value) {
    [[maybe_unused]] const float* end = out_ + width;
    if constexpr (std::invocable<const Value&, RowWriter&>) {
      value(*this);
    } else if constexpr (std::is_pointer_v<std::invoke_result_t<const Value&>>) {
      add(value(), width);
    } else {
      add(value());
    }
    assert(out_ == end);
  }

  template <class Number>
  requires std::is_arithmetic_v<Number>
  void add(Number value) { *out_++ = static_cast<float>(value); }
  template <class Number>
  void add(const Number* values, int count) {
    for (int i = 0; i < count; ++i) add(values[i]);
  }
  void add(const Eigen::Vector3d& vector) { add(vector.data(), 3); }
  // Seven numbers: position, quaternion (w, x, y, z).
  void add_pose(const double* pos, const double* quat) {
    add(pos, 3);
    add(quat, 4);
  }
  void add(const Pose& pose) { add_pose(pose.pos, pose.quat); }

 private:
  float* out_;
};

}  // namespace engram::tasks
