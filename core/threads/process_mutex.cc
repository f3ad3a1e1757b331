#include "core/threads/process_mutex.h"

#include <pthread.h>

#include <array>

namespace engram {
namespace {

constinit std::array<std::mutex, static_cast<std::size_t>(ProcessLock::kThreads) + 1> locks;

void lock_all() {
  for (std::mutex& lock : locks) lock.lock();
}

void unlock_all() {
  for (auto lock = locks.rbegin(); lock != locks.rend(); ++lock) lock->unlock();
}

// If memory for the handlers runs out, children may wait as they would without them.
[[maybe_unused]] const int forks_wait = pthread_atfork(lock_all, unlock_all, unlock_all);

}  // namespace

std::mutex& process_mutex(ProcessLock what) noexcept {
  return locks[static_cast<std::size_t>(what)];
}

}  // namespace engram
