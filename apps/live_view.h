// Progress of many tasks, for people at a terminal.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace engram::apps {

// Lines on standard error that are redrawn in place: two bars, and a table of tasks.
// Appears after two seconds, if standard error is a terminal; the destructor erases it.
class LiveView {
 public:
  struct TaskProgress {
    std::string name;
    double fraction;  // 0 to 1
    std::string note;
  };
  struct ProgressBar {
    std::string label;
    double fraction;  // 0 to 1
    std::string note;
  };

  LiveView();
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  // True when the next frame is due.
  bool due() const;
  // The time left is worked out from the first bar.
  void draw(const std::vector<ProgressBar>& bars, const std::vector<TaskProgress>& tasks);

 private:
  using Clock = std::chrono::steady_clock;

  void erase();

  bool terminal_;
  std::size_t lines_ = 0;  // shown
  Clock::time_point start_;
  Clock::time_point next_;
};

}  // namespace engram::apps
