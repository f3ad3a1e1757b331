#include "apps/interruption.h"

#include <csignal>
#include <string>

#include "protocol/batch/make.h"

namespace engram::apps {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM};
volatile std::sig_atomic_t interrupted = 0;

}  // namespace

Interruption::Interruption() {
  for (const int signal : kSignals) std::signal(signal, [](int) { interrupted = 1; });
}

Interruption::~Interruption() {
  for (const int signal : kSignals) std::signal(signal, SIG_DFL);
}

bool Interruption::requested() const { return interrupted != 0; }

void Interruption::check(std::string_view state) const {
  if (requested()) throw Error(Error::kIo, "interrupted; " + std::string(state));
}

}  // namespace engram::apps
