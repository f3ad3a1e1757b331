#include "apps/interruption.h"

#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdlib>
#include <string>

#include "protocol/make/make.h"

namespace engram::apps {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};
std::atomic<bool> interrupted = false;
std::atomic<unsigned> seconds_left = 0;
static_assert(std::atomic<bool>::is_always_lock_free);  // signal handlers may set it
static_assert(std::atomic<unsigned>::is_always_lock_free);

// Both do only what a signal handler may.

void note(int signal) {
  interrupted = true;
  std::signal(signal, SIG_DFL);
  if (const unsigned seconds = seconds_left; seconds > 0) ::alarm(seconds);
}

void give_up(int /*signal*/) {
  constexpr std::string_view kWords =
      "engram: interrupted; ended without waiting for what was under way\n";
  if (::write(STDERR_FILENO, kWords.data(), kWords.size()) < 0) ::_exit(EXIT_FAILURE);
  ::_exit(EXIT_FAILURE);
}

}  // namespace

Interruption::Interruption(unsigned grace) {
  seconds_left = grace;
  if (grace > 0) std::signal(SIGALRM, give_up);
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
}

const std::atomic<bool>& Interruption::flag() const { return interrupted; }

void Interruption::check(std::string_view state) const {
  if (requested()) throw Error(Error::kIo, "interrupted; " + std::string(state));
}

}  // namespace engram::apps
