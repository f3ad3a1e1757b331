// A task whose constants may contradict values of its options.
#pragma once

#include <span>

namespace engram {

class OptionCheck {
 public:
  virtual ~OptionCheck() = default;

  // Throws Error (kInvalidArgument) unless the task can be played with these values of
  // TaskInfo::options, in order.
  virtual void check_options(std::span<const double> options) const = 0;
};

}  // namespace engram
