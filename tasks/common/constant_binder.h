// Declaration of a task's constants. A family's parameters declare them once, in a member
//   void declare(ConstantBinder& constants)
// with one line per constant: its name, where it is kept, the values that users may choose, and a
// description. What follows from that line: the check and the assignment of a user's value, the
// task's description, and the random variable of a range (tasks/common/random_variables.h).
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/index.h"
#include "core/task/task_constant.h"
#include "tasks/common/colors.h"
#include "tasks/common/sampled_range.h"

namespace engram::tasks {

// A choice out of a table of names, by index; without repetition. Named by the class constants.
class NameList {
 public:
  static constexpr int kCapacity = 16;

  constexpr NameList() = default;
  // 0, ..., count - 1.
  constexpr explicit NameList(int count) : size_(count) {
    for (int i = 0; i < count; ++i) indices_[at(i)] = i;
  }

  constexpr int size() const { return size_; }
  constexpr int operator[](int i) const { return indices_[at(i)]; }
  constexpr void clear() { size_ = 0; }
  constexpr void push_back(int index) { indices_[at(size_++)] = index; }

 private:
  std::array<int, kCapacity> indices_{};
  int size_ = 0;
};

// Both included.
struct Bounds {
  double low = 0;
  double high = 0;
};

class ConstantBinder {
 public:
  // A list of names as the class constant has it.
  using PublishedForm = std::function<Constant(const NameList&)>;

  // chosen: the values that users chose, by name. Throws Error if one is there twice.
  explicit ConstantBinder(const ConstantTable& chosen);

  // Each of these declares a constant that users may change, and sets it if its name was chosen.
  // They throw Error (kInvalidArgument), naming what is allowed, for a value of another type or
  // beyond its bounds. The result is the constant until the next one is declared.
  TaskConstant& integer(const char* name, int& value, Bounds bounds, const char* unit,
                        const char* text);
  TaskConstant& real(const char* name, double& value, Bounds bounds, const char* unit,
                     const char* text);
  TaskConstant& reals(const char* name, std::span<double> values, Bounds bounds, const char* unit,
                      const char* text);
  // index: of the name in `names`.
  TaskConstant& name(const char* name, int& index, std::span<const char* const> names,
                     const char* text);
  TaskConstant& names(const char* name, NameList& value, std::span<const char* const> names,
                      int least, const char* text, const PublishedForm& published);
  // The class constant is a table of arrays of red, green, blue and alpha.
  TaskConstant& colors(const char* name, ColorList& value, int least, const char* text);

  // A range, and the random variable that episodes draw from it.
  TaskConstant& range(const char* name, SampledRange<int>& value, Bounds bounds, const char* unit,
                      const char* text, VariableName variable);
  TaskConstant& range(const char* name, SampledRange<double>& value, Bounds bounds,
                      const char* unit, const char* text, VariableName variable);
  TaskConstant& steps(const char* name, StepRange& value, Bounds bounds, const char* text,
                      VariableName variable);

  // Class constants that cannot be changed.
  void fixed(const ConstantTable& values);
  // Fixes all that `declare` declares.
  template <std::invocable Declare>
  void fixed(const Declare& declare) {
    const bool before = fixed_;
    fixed_ = true;
    declare();
    fixed_ = before;
  }

  // All that were declared, as they are now. Throws Error: kUnknownId, with the nearest name, for a
  // chosen name that was not declared; kInvalidArgument for another value of one that users may not
  // change.
  std::vector<TaskConstant> take();

 private:
  using Kind = TaskConstant::Kind;

  const Constant* find(std::string_view name) const;
  // The user's value in the form in which it is kept, checked, until the next one is added, or
  // null; as numbers, none where there is none.
  const Constant* add(TaskConstant about);
  std::span<const Constant> add_numbers(const char* name, Kind kind, Constant value, Bounds bounds,
                                        const char* unit, const char* text);
  // The one that was declared last, whose value is now `value`.
  TaskConstant& set(Constant value);
  // Throws Error unless a chosen value of a constant that nobody may change is its own.
  void check_fixed(const std::string& name, const Constant& chosen) const;
  template <class T>
  TaskConstant& add_range(const char* name, Kind kind, SampledRange<T>& value, Bounds bounds,
                          const char* unit, const char* text, VariableName variable);

  const ConstantTable& chosen_;
  std::vector<TaskConstant> declared_;
  std::optional<Constant> given_;  // the user's value of the last one
  bool fixed_ = false;
};

// "53 mm", for messages.
std::string in_millimetres(double metres);

// Throws Error (kInvalidArgument): constant 'name': `given` given, `allowed`.
[[noreturn]] void refuse_constant(const std::string& name, const std::string& given,
                                  const std::string& allowed);

}  // namespace engram::tasks
