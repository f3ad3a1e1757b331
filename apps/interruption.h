// Ctrl-C and SIGTERM, noticed where the program can stop cleanly.
#pragma once

#include <atomic>
#include <string_view>

namespace engram::apps {

// While an object lives, the first signal is only noted; the second one ends the program.
class Interruption {
 public:
  // More than a policy's process gets to end by itself.
  static constexpr unsigned kPatience = 4;

  // patience: seconds after a signal in which the program ends in any case, with exit code 1,
  // because threads may be at something that cannot be stopped; 0: no such limit. Files are whole
  // then, too.
  explicit Interruption(unsigned patience = kPatience);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // Whether there was a signal.
  bool requested() const { return flag(); }
  // Set by a signal, for what waits elsewhere.
  const std::atomic<bool>& flag() const;

  // Throws Error if there was a signal; `state` says what has been saved.
  void check(std::string_view state) const;
};

}  // namespace engram::apps
