// How users change the constants of a task. A family's parameters list them once, in a member
//   void constants(Changes& list)
// with one line per constant: its name, where it is kept, what is allowed and what it is for. That
// line is all that checks, sets and describes it.
#pragma once

#include <array>
#include <cstddef>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/env/task_constant.h"
#include "tasks/common/step_range.h"

namespace engram::tasks {

// A choice out of a table of names, by index; without repetition. Named by the class constants.
class NameList {
 public:
  static constexpr int kCapacity = 16;

  constexpr NameList() = default;
  // 0, ..., count - 1.
  constexpr explicit NameList(int count) : size_(count) {
    for (int i = 0; i < count; ++i) indices_[static_cast<std::size_t>(i)] = i;
  }

  constexpr int size() const { return size_; }
  constexpr int operator[](int i) const { return indices_[static_cast<std::size_t>(i)]; }
  constexpr void clear() { size_ = 0; }
  constexpr void push_back(int index) { indices_[static_cast<std::size_t>(size_++)] = index; }

 private:
  std::array<int, kCapacity> indices_{};
  int size_ = 0;
};

// Both included.
struct Bounds {
  double low = 0;
  double high = 0;
};

class Changes {
 public:
  // given: the values that users chose, by name. Throws Error if one is there twice.
  explicit Changes(const ConstantTable& given);

  // Each of these describes a constant and sets it if its name was given. They throw Error
  // (kInvalidArgument), naming what is allowed, for a value of another type or beyond its bounds.
  void integer(const char* name, int& value, Bounds bounds, const char* unit, const char* text);
  void real(const char* name, double& value, Bounds bounds, const char* unit, const char* text);
  void steps(const char* name, StepRange& value, Bounds bounds, const char* text);
  void integer_range(const char* name, int& low, int& high, Bounds bounds, const char* unit,
                     const char* text);
  void real_range(const char* name, double& low, double& high, Bounds bounds, const char* unit,
                  const char* text);
  void reals(const char* name, std::span<double> values, Bounds bounds, const char* unit,
             const char* text);
  // index: of the name in `names`.
  void name(const char* name, int& index, std::span<const char* const> names, const char* text);
  void names(const char* name, NameList& value, std::span<const char* const> names, int least,
             const char* text);

  // Whether the user gave it.
  bool has(std::string_view name) const { return find(name) != nullptr; }

  // All that were listed, as they are now. Throws Error (kUnknownId), with the nearest name, if one
  // was given that was not listed.
  std::vector<TaskConstant> take();

 private:
  using Kind = TaskConstant::Kind;

  const Constant* find(std::string_view name) const;
  // What was given, checked, or null; as numbers, none if nothing was given.
  const Constant* add(TaskConstant about);
  std::span<const Constant> add_numbers(const char* name, Kind kind, Constant value, Bounds bounds,
                                        const char* unit, const char* text);

  const ConstantTable& given_;
  std::vector<TaskConstant> listed_;
};

// How long a phase may be, control steps.
inline constexpr Bounds kPhaseSteps{1, 100'000};

// "53 mm", for messages.
std::string in_millimetres(double metres);

// Throws Error (kInvalidArgument): constant 'name': `given` given, `allowed`.
[[noreturn]] void refuse_constant(const std::string& name, const std::string& given,
                                  const std::string& allowed);

// A stretch of an episode: how many control steps a constant of that name makes it at most.
struct Stretch {
  const char* name;
  int steps;
};

// Throws Error (kInvalidArgument), with the sum, unless the horizon leaves so many control steps to
// act.
void check_time(int horizon, std::initializer_list<Stretch> stretches, int least_to_act);

}  // namespace engram::tasks
