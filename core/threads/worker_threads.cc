#include "core/threads/worker_threads.h"

#include <unistd.h>

#include <algorithm>
#include <mutex>
#include <string>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/base/index.h"
#include "core/threads/process_mutex.h"
#include "core/threads/processors.h"
#include "core/threads/spin_wait.h"

namespace engram {
namespace {

// How long a thread polls for the next loop before it sleeps: while its usual pause between two
// loops is shorter, twice that pause; otherwise the least.
constexpr std::int64_t kMinPolling = 5'000;            // ns
constexpr std::int64_t kLongestPolledPause = 150'000;  // ns

// Usual pause between two loops that a thread has worked on.
class UsualPause {
 public:
  void add(std::int64_t pause) noexcept {
    pause = std::min(pause, 4 * kLongestPolledPause);
    mean_ += (pause - mean_) / 4;
  }
  std::int64_t polling_time() const noexcept {
    return mean_ < kLongestPolledPause ? kMinPolling + 2 * mean_ : kMinPolling;
  }

 private:
  std::int64_t mean_ = 0;  // ns
};

}  // namespace

WorkerThreads::WorkerThreads(int helpers) : owner_(::getpid()) {
  if (helpers < 0 || helpers >= kMaxThreads) {
    throw Error(Error::kInvalidArgument, "number of threads is " + std::to_string(helpers + 1) +
                                             "; allowed are 1 to " + std::to_string(kMaxThreads));
  }
  threads_.reserve(at(helpers));
  try {
    for (int i = 0; i < helpers; ++i) threads_.emplace_back([this] { serve(); });
  } catch (const std::exception& error) {
    // Out of threads, or of memory for one.
    stop();
    throw Error(Error::kUnavailable,
                "number of threads is " + std::to_string(helpers + 1) + "; the system allows " +
                    std::to_string(this->helpers() + 1) + " (" + error.what() + ")");
  }
}

WorkerThreads::~WorkerThreads() { stop(); }

bool WorkerThreads::forked() const noexcept { return ::getpid() != owner_; }

void WorkerThreads::stop() noexcept {
  stopping_.store(true);
  wake(helpers());
  for (std::thread& thread : threads_) {
    // A child of fork() has no other threads to wait for.
    if (forked()) {
      thread.detach();
    } else {
      thread.join();
    }
  }
}

std::shared_ptr<WorkerThreads> WorkerThreads::of_process() {
  // Never destroyed: threads may still make batches while the process ends.
  static auto* const current = new std::weak_ptr<WorkerThreads>;
  const std::lock_guard lock(process_mutex(ProcessLock::kThreads));
  std::shared_ptr<WorkerThreads> threads = current->lock();
  if (threads == nullptr || threads->forked()) {
    const int helpers = std::min(usable_processors(), kMaxThreads) - 1;
    threads = std::make_shared<WorkerThreads>(helpers);
    *current = threads;
  }
  return threads;
}

SharedLoop* WorkerThreads::take_place() noexcept {
  for (int i = 0; i < kMaxLoops; ++i) {
    if (!loops_[at(i)].take()) continue;
    int places = places_.load();
    while (places <= i && !places_.compare_exchange_weak(places, i + 1)) continue;
    return &loops_[at(i)];
  }
  return nullptr;
}

void WorkerThreads::wake(int helpers) noexcept {
  opened_.fetch_add(1);
  if (helpers >= this->helpers()) {
    opened_.notify_all();
  } else {
    for (int i = 0; i < helpers; ++i) opened_.notify_one();
  }
}

std::exception_ptr WorkerThreads::run(const LoopWork& work, std::int64_t* busy) noexcept {
  SharedLoop* const place = take_place();
  if (place == nullptr) {
    SharedLoop alone;
    alone.open(work);
    return alone.finish(busy);
  }
  place->open(work);
  wake(work.workers - 1);
  std::exception_ptr error = place->finish(busy);
  place->release();
  return error;
}

bool WorkerThreads::help() noexcept {
  SharedLoop* chosen = nullptr;
  int fewest = kMaxThreads + 1;
  const int places = places_.load();
  for (int i = 0; i < places; ++i) {
    const int workers = loops_[at(i)].workers_if_open();
    if (workers == 0 || workers >= fewest) continue;
    fewest = workers;
    chosen = &loops_[at(i)];
  }
  return chosen != nullptr && chosen->help();
}

void WorkerThreads::serve() noexcept {
  const IeeeScope scope;  // a new thread has the mode of the one that starts it
  UsualPause pause;
  std::int64_t idle_since = now_ns();
  SpinWait spin(pause.polling_time());
  for (;;) {
    const std::uint32_t opened = opened_.load();
    if (stopping_.load()) return;
    const std::int64_t start = now_ns();
    if (help()) {
      pause.add(start - idle_since);
      idle_since = now_ns();
      spin = SpinWait(pause.polling_time());
      continue;
    }
    bool polling = true;
    while (polling && opened_.load() == opened) polling = spin.poll();
    if (!polling) opened_.wait(opened);
  }
}

}  // namespace engram
