// Ctrl-C and termination, told at points where the program can stop in good order.
#pragma once

#include <string_view>

namespace engram::apps {

// While one lives, both signals wait for a check.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // Whether there was a signal.
  bool requested() const;

  // Throws Error if there was a signal; `state` tells what has become of the work.
  void check(std::string_view state) const;
};

}  // namespace engram::apps
