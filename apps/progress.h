// A progress bar on standard error.
#pragma once

#include <chrono>
#include <string>

namespace engram::apps {

inline constexpr std::chrono::seconds kProgressPatience{2};  // before anything is shown

// A duration as "1:23:45", or "23:45" below an hour.
std::string clock_text(double seconds);

// Appears after two seconds, if standard error is a terminal; the destructor erases it.
class Progress {
 public:
  // unit: what `count` counts, such as "steps"; may be empty, then no rate is shown.
  Progress(std::string label, std::string unit);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  // fraction: of the whole, 0 to 1. Cheap enough for every control step.
  void update(double fraction, double count = 0);

 private:
  using Clock = std::chrono::steady_clock;

  void draw(double fraction, double count, double seconds);

  std::string label_;
  std::string unit_;
  bool terminal_;
  bool shown_ = false;
  Clock::time_point start_;
  Clock::time_point next_;
};

}  // namespace engram::apps
