#include "apps/live_view.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "apps/progress.h"

namespace engram::apps {
namespace {

constexpr std::chrono::milliseconds kRefresh{250};
constexpr std::size_t kMaxRows = 12;

std::string bar_text(double fraction, int cells) {
  const auto filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * cells);
  return fmt::format("[{:#<{}}{:-<{}}] {:3.0f} %", "", filled, "", cells - filled,
                     100 * std::clamp(fraction, 0.0, 1.0));
}

}  // namespace

LiveView::LiveView()
    : terminal_(::isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      next_(start_ + kProgressPatience) {}

LiveView::~LiveView() { erase(); }

bool LiveView::due() const { return terminal_ && Clock::now() >= next_; }

void LiveView::draw(const std::vector<ProgressBar>& bars, const std::vector<TaskProgress>& tasks) {
  const Clock::time_point now = Clock::now();
  next_ = now + kRefresh;
  const double seconds = std::chrono::duration<double>(now - start_).count();
  std::vector<std::string> lines;
  lines.reserve(bars.size() + tasks.size());
  for (const ProgressBar& bar : bars) {
    lines.push_back(fmt::format("{:<9} {}  {}", bar.label, bar_text(bar.fraction, 32), bar.note));
  }
  if (!lines.empty()) {
    lines[0] += fmt::format("  {}", clock_text(seconds));
    const double fraction = bars[0].fraction;
    if (fraction > 0) lines[0] += fmt::format(", ETA {}", clock_text(seconds * (1 / fraction - 1)));
  }
  for (std::size_t i = 0; i < std::min(tasks.size(), kMaxRows); ++i) {
    lines.push_back(fmt::format("  {:<44} {}  {}", tasks[i].name, bar_text(tasks[i].fraction, 16),
                                tasks[i].note));
  }
  if (tasks.size() > kMaxRows)
    lines.push_back(fmt::format("  ... {} more", tasks.size() - kMaxRows));

  erase();
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  std::fputs(text.c_str(), stderr);
  std::fflush(stderr);
  lines_ = lines.size();
}

// Back to where the view began, and everything below gone.
void LiveView::erase() {
  if (lines_ == 0) return;
  std::fputs(fmt::format("\033[{}A\r\033[J", lines_).c_str(), stderr);
  std::fflush(stderr);
  lines_ = 0;
}

}  // namespace engram::apps
