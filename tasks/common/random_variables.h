// Random variables of a family's episodes. A family declares them once, one after the other, in the
// constructor of a struct of handles:
//   struct Variables {
//     Variables(RandomVariables list, const Params& params)
//         : color(list.integer("color", {0, kColors - 1}, "", "colour of the flash")),
//           cue_steps(list.of(params.CUE_PHASE_STEPS)) {}
//     IntegerVariable color;
//     IntegerVariable cue_steps;
//   };
// The order is that of their random streams and of TaskInfo::random_variables.
#pragma once

#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/task/episode.h"
#include "tasks/common/sampled_range.h"

namespace engram::tasks {

// Handle of a variable from whose stream the family draws by itself.
class VariableHandle {
 public:
  VariableHandle() = default;
  explicit VariableHandle(int index) : index_(index) {}

  int index() const { return index_; }
  // Values that the user has fixed, or null.
  const double* pinned(const Episode& episode) const { return episode.pinned(index_); }
  RandomStream stream(const Episode& episode) const { return episode.stream(index_); }

 private:
  int index_ = 0;
};

// Least and greatest value.
template <class T>
struct Interval {
  T low{};
  T high{};
};

// Handle of a variable whose values are uniform over an interval.
template <class T>
class UniformVariable : public VariableHandle {
 public:
  UniformVariable() = default;
  UniformVariable(int index, Interval<T> interval) : VariableHandle(index), interval_(interval) {}

  T low() const { return interval_.low; }
  T high() const { return interval_.high; }
  // The interval of an episode, which the user may have narrowed.
  Interval<T> interval(const Episode& episode) const {
    Interval<T> own = interval_;
    episode.narrow(index(), own.low, own.high);
    return own;
  }
  // The pinned value, or one drawn from that interval.
  T sample(const Episode& episode) const { return sample_from(episode, interval_); }
  // The pinned value, or one drawn from a smaller interval.
  T sample_from(const Episode& episode, Interval<T> interval) const {
    if constexpr (std::is_integral_v<T>) {
      return episode.integer(index(), interval.low, interval.high);
    } else {
      return episode.real(index(), interval.low, interval.high);
    }
  }

 private:
  Interval<T> interval_;
};

using IntegerVariable = UniformVariable<int>;
using RealVariable = UniformVariable<double>;

// List builder: describes a variable in TaskInfo::random_variables and returns its handle.
class RandomVariables {
 public:
  explicit RandomVariables(std::vector<RandomVariable>& list) : list_(&list) {}

  VariableHandle add(RandomVariable about) {
    list_->push_back(std::move(about));
    return VariableHandle(static_cast<int>(list_->size()) - 1);
  }
  IntegerVariable integer(std::string name, Interval<int> interval, std::string unit,
                          std::string description) {
    return uniform(std::move(name), interval, std::move(unit), std::move(description));
  }
  RealVariable real(std::string name, Interval<double> interval, std::string unit,
                    std::string description) {
    return uniform(std::move(name), interval, std::move(unit), std::move(description));
  }
  // A value of a constant's range, or `width` of them.
  template <class T>
  UniformVariable<T> of(const SampledRange<T>& range, int width = 1) {
    const auto handle = uniform<T>(range.variable.name, {range.low, range.high}, range.unit,
                                   range.variable.description);
    list_->back().width = width;
    list_->back().constant = range.constant;
    return handle;
  }

 private:
  template <class T>
  UniformVariable<T> uniform(std::string name, Interval<T> interval, std::string unit,
                             std::string description) {
    const VariableHandle handle = add({.name = std::move(name),
                                       .integer = std::is_integral_v<T>,
                                       .low = static_cast<double>(interval.low),
                                       .high = static_cast<double>(interval.high),
                                       .unit = std::move(unit),
                                       .description = std::move(description)});
    return {handle.index(), interval};
  }

  std::vector<RandomVariable>* list_;
};

}  // namespace engram::tasks
