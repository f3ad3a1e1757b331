#include "apps/interruption.h"

#include <csignal>
#include <string>

#include "protocol/batch/make.h"

namespace engram::apps {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM};
std::atomic<bool> interrupted = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // signal handlers may set it

}  // namespace

Interruption::Interruption() {
  for (const int signal : kSignals) std::signal(signal, [](int) { interrupted = true; });
}

Interruption::~Interruption() {
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
}

const std::atomic<bool>& Interruption::flag() const { return interrupted; }

void Interruption::check(std::string_view state) const {
  if (requested()) throw Error(Error::kIo, "interrupted; " + std::string(state));
}

}  // namespace engram::apps
