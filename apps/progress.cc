#include "apps/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace engram::apps {
namespace {

constexpr std::chrono::milliseconds kRedraw{100};

std::string rate_text(double rate) {
  if (rate >= 1e6) return fmt::format("{:.2f}M", rate / 1e6);
  if (rate >= 1e3) return fmt::format("{:.1f}k", rate / 1e3);
  return fmt::format("{:.0f}", rate);
}

}  // namespace

std::string clock_text(double seconds) {
  const long total = std::lround(seconds);
  if (total >= 3600)
    return fmt::format("{}:{:02}:{:02}", total / 3600, total / 60 % 60, total % 60);
  return fmt::format("{}:{:02}", total / 60, total % 60);
}

Progress::Progress(std::string label, std::string unit)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      terminal_(::isatty(STDERR_FILENO) == 1),
      start_(Clock::now()),
      next_(start_ + kProgressPatience) {}

Progress::~Progress() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void Progress::update(double fraction, double count) {
  if (!terminal_) return;
  const Clock::time_point now = Clock::now();
  if (now < next_) return;
  next_ = now + kRedraw;
  draw(std::clamp(fraction, 0.0, 1.0), count, std::chrono::duration<double>(now - start_).count());
}

void Progress::draw(double fraction, double count, double seconds) {
  constexpr int kCells = 24;
  const auto filled = static_cast<int>(fraction * kCells);
  std::string line = fmt::format("\r\033[K{} [{:#<{}}{:-<{}}] {:3.0f} %", label_, "", filled, "",
                                 kCells - filled, 100 * fraction);
  if (!unit_.empty()) line += fmt::format("  {} {}/s", rate_text(count / seconds), unit_);
  if (fraction > 0) line += fmt::format("  ETA {}", clock_text(seconds * (1 / fraction - 1)));
  std::fputs(line.c_str(), stderr);
  std::fflush(stderr);
  shown_ = true;
}

}  // namespace engram::apps
