#include "apps/interruption.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <string>

#include "protocol/make/make.h"

namespace engram::apps {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};
std::atomic<bool> interrupted = false;
std::atomic<bool> timed_out = false;
std::atomic<unsigned> seconds_left = 0;
const std::chrono::steady_clock::time_point program_start = std::chrono::steady_clock::now();
static_assert(std::atomic<bool>::is_always_lock_free);  // signal handlers may set it
static_assert(std::atomic<unsigned>::is_always_lock_free);

// These do only what a signal handler may.

void give_up(int /*signal*/) {
  constexpr std::string_view kWords =
      "engram: interrupted; ended without waiting for what was under way\n";
  if (::write(STDERR_FILENO, kWords.data(), kWords.size()) < 0) ::_exit(EXIT_FAILURE);
  ::_exit(EXIT_FAILURE);
}

// The alarm of a time limit gives way to that of the grace.
void begin_grace() {
  std::signal(SIGALRM, give_up);
  ::alarm(seconds_left);
}

void note(int signal) {
  interrupted = true;
  std::signal(signal, SIG_DFL);
  begin_grace();
}

void end_time(int /*signal*/) {
  timed_out = true;
  interrupted = true;
  begin_grace();
}

// Seconds of the limit that are left, at least one.
unsigned left_of(unsigned limit) {
  const auto used = std::chrono::duration_cast<std::chrono::seconds>(
      std::chrono::steady_clock::now() - program_start);
  return std::max(1U, limit - std::min(limit, static_cast<unsigned>(used.count())));
}

}  // namespace

Interruption::Interruption(unsigned grace, unsigned limit) {
  seconds_left = grace;
  if (limit > 0) {
    std::signal(SIGALRM, end_time);
    ::alarm(left_of(limit));
  }
  for (const int signal : kSignals) {
    // As nohup has it.
    if (std::signal(signal, note) == SIG_IGN && signal == SIGHUP) std::signal(signal, SIG_IGN);
  }
}

Interruption::~Interruption() {
  for (const int signal : kSignals) {
    if (std::signal(signal, SIG_DFL) == SIG_IGN) std::signal(signal, SIG_IGN);
  }
  seconds_left = 0;
  // No alarm of a limit comes later; that of a grace does.
  if (!interrupted) ::alarm(0);
}

const std::atomic<bool>& Interruption::flag() const { return interrupted; }

void Interruption::check(std::string_view state) const {
  if (!requested()) return;
  const char* const why = timed_out ? "interrupted by --time-limit; " : "interrupted; ";
  throw Error(Error::kIo, why + std::string(state));
}

}  // namespace engram::apps
