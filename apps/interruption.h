// Ctrl-C, SIGTERM, SIGHUP and SIGUSR1 (which schedulers send before the time is up), and the end of
// a time limit, noticed where the program can stop cleanly.
#pragma once

#include <atomic>
#include <string_view>

namespace engram::apps {

// While an object lives, the first signal is only noted; the second one ends the program.
class Interruption {
 public:
  // Longer than a policy's process has to end by itself.
  static constexpr unsigned kGraceSeconds = 4;

  // grace: seconds after a signal in which the program ends in any case, with exit code 1,
  // because threads may be at something that cannot be stopped; 0: no such limit. Files are whole
  // then, too.
  // limit: seconds from the program's start on after which it is as if a signal came; 0: none.
  explicit Interruption(unsigned grace = kGraceSeconds, unsigned limit = 0);
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  // True after a signal.
  bool requested() const { return flag(); }
  // Set by a signal, for code that waits elsewhere.
  const std::atomic<bool>& flag() const;

  // Throws Error if there was a signal, or the time is up; `state` says what has been saved.
  void check(std::string_view state) const;
};

}  // namespace engram::apps
