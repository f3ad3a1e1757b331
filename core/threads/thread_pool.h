// Parallel loops over the environments of a batch.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "core/threads/worker_threads.h"

namespace engram {

// Loops shared by up to `threads` threads: the calling one, as worker 0, and helpers of the
// process's WorkerThreads. A loop gets as many of them as its measured cost pays for.
class ThreadPool {
 public:
  static constexpr int kMaxThreads = WorkerThreads::kMaxThreads;

  // threads: 1 to kMaxThreads, the caller included; with more than the process has processors,
  // fewer work. unit: ranges are multiples of it where they can be. workers: tests have their own.
  // Throws Error if an argument is out of range (kInvalidArgument) or if the system refuses a
  // thread (kUnavailable).
  explicit ThreadPool(int threads, int unit = 1, std::shared_ptr<WorkerThreads> workers = {});

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const noexcept { return threads_; }

  // Calls f(worker, begin, end) for neighbouring ranges of [0, items), each range once, on
  // whichever worker is free (0 <= worker < threads()), and returns when all are done. Every call
  // of f computes in an IeeeScope. Does not allocate.
  //
  // Ranges have `chunk` items at most. If several threads share a loop, its last ranges get shorter
  // and shorter, so that no thread waits long for the last one. How many threads share it depends
  // on the time that loops with this f have taken before.
  //
  // If f throws, the other ranges are still run. Then the exception of the lowest range is
  // rethrown.
  //
  // Throws Error if items < 0 or chunk < 1 (kInvalidArgument), or if a loop is running already
  // (kBadState): loops neither nest nor overlap.
  template <typename F>
  void run(int items, int chunk, F&& f) {
    using Function = std::remove_reference_t<F>;
    const LoopWork::Body body = [](const void* context, int worker, int begin, int end) {
      (*static_cast<Function*>(const_cast<void*>(context)))(worker, begin, end);
    };
    run_loop({body, std::addressof(f), items, chunk, 1, 1});
  }

 private:
  // Measured cost of the loops with one body.
  struct Cost {
    LoopWork::Body body = nullptr;
    double per_item = -1;  // ns; -1: unknown
  };
  static constexpr std::size_t kMaxCosts = 8;

  void run_loop(LoopWork work);
  Cost& cost_of(LoopWork::Body body) noexcept;
  int workers_for(const LoopWork& work, const Cost& cost) const noexcept;

  int threads_;
  int unit_;
  std::shared_ptr<WorkerThreads> workers_;
  std::array<Cost, kMaxCosts> costs_;
  std::size_t next_cost_ = 0;
  std::atomic<bool> running_ = false;
};

}  // namespace engram
