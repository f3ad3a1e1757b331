// Constants that are ranges, from which every episode draws.
#pragma once

namespace engram::tasks {

// Random variable of a range, by name and in words.
struct VariableName {
  const char* name = "";
  const char* description = "";
};

// Range of a constant, both ends included; the declaration of the constant names the rest
// (tasks/common/constant_binder.h).
template <class T>
struct SampledRange {
  T low{};
  T high{};
  VariableName variable = {};
  const char* unit = "";
  const char* constant = "";  // by which resets may narrow it; "" where they may not

  // Equal values.
  friend constexpr bool operator==(const SampledRange& one, const SampledRange& other) {
    return one.low == other.low && one.high == other.high;
  }
};

// Range of a number of control steps.
using StepRange = SampledRange<int>;

}  // namespace engram::tasks
