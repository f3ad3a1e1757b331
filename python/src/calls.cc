#include "calls.h"

#include <pthread.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace engram_python {
namespace {

constexpr std::chrono::seconds kLongestWait{10};
constexpr std::chrono::milliseconds kPause{1};

// Calls of this process: a forked one has none of the counted threads.
std::atomic<int> running_calls = 0;
std::atomic<bool> ended = false;
pthread_t ender;  // the thread that ends the calls; it may call on. Written before `ended`

bool is_held_back() { return ended && pthread_equal(ender, pthread_self()) == 0; }

const int forgotten_by_children = pthread_atfork(nullptr, nullptr, [] { running_calls = 0; });

}  // namespace

void sleep_forever() {
  for (;;) pause();
}

void hold_back() {
  if (is_held_back()) sleep_forever();
}

void hold_back_locked() {
  if (!is_held_back()) return;
  PyEval_SaveThread();
  sleep_forever();
}

bool calls_have_ended() { return ended; }

Call::Call() {
  ++running_calls;
  if (!is_held_back()) return;
  --running_calls;
  sleep_forever();
}

Call::~Call() { --running_calls; }

void end_calls() {
  if (ended) return;
  ender = pthread_self();
  ended = true;
  PyThreadState* const state = PyEval_SaveThread();
  const auto end = std::chrono::steady_clock::now() + kLongestWait;
  while (running_calls > 0 && std::chrono::steady_clock::now() < end) {
    std::this_thread::sleep_for(kPause);
  }
  unless_ended([state] { PyEval_RestoreThread(state); });
}

}  // namespace engram_python
