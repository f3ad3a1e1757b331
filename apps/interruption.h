// Ctrl-C and SIGTERM, noticed where the program can stop cleanly.
#pragma once

#include <atomic>
#include <string_view>

namespace engram::apps {

// While an object lives, both signals are only noted.
class Interruption {
 public:
  Interruption();
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
