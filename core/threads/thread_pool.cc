#include "core/threads/thread_pool.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"
#include "core/threads/spin_wait.h"

namespace engram {
namespace {

// Work that pays for another thread: several times what waking it costs.
constexpr double kMinShare = 40'000;  // ns

// Share of the latest loop in the mean of measured costs.
constexpr double kLatest = 0.125;

// Runs a loop on the calling thread.
std::exception_ptr run_alone(const LoopWork& work, std::int64_t* busy) noexcept {
  std::exception_ptr error;
  const std::int64_t start = now_ns();
  for (int begin = 0; begin < work.items;) {
    const int end = begin + std::min(work.chunk, work.items - begin);
    try {
      work.body(work.context, 0, begin, end);
    } catch (...) {
      if (!error) error = std::current_exception();
    }
    begin = end;
  }
  *busy = now_ns() - start;
  return error;
}

}  // namespace

ThreadPool::ThreadPool(int threads, int unit, std::shared_ptr<WorkerThreads> workers)
    : threads_(threads), unit_(unit), workers_(std::move(workers)) {
  if (threads < 1 || threads > kMaxThreads) {
    throw Error(Error::kInvalidArgument, "number of threads is " + std::to_string(threads) +
                                             "; allowed are 1 to " + std::to_string(kMaxThreads));
  }
  if (unit < 1) {
    throw Error(Error::kInvalidArgument,
                "unit of ranges is " + std::to_string(unit) + "; allowed are 1 and more");
  }
  if (threads > 1 && workers_ == nullptr) workers_ = WorkerThreads::of_process();
}

void ThreadPool::run_loop(LoopWork work) {
  if (work.items < 0 || work.chunk < 1) {
    throw Error(Error::kInvalidArgument, "loop over " + std::to_string(work.items) +
                                             " items in chunks of " + std::to_string(work.chunk) +
                                             "; allowed are items >= 0 and chunk >= 1");
  }
  if (running_.exchange(true, std::memory_order_acquire)) {
    throw Error(Error::kBadState,
                "this thread pool is running a loop; loops cannot nest or overlap");
  }
  const IeeeScope scope;
  Cost& cost = cost_of(work.body);
  work.unit = std::min(unit_, work.chunk);
  work.workers = workers_for(work, cost);
  std::int64_t busy = 0;
  const std::exception_ptr error =
      work.workers > 1 ? workers_->run(work, &busy) : run_alone(work, &busy);
  if (work.items > 0) {
    const double per_item = static_cast<double>(busy) / work.items;
    if (cost.per_item < 0) cost.per_item = per_item;
    cost.per_item += kLatest * (per_item - cost.per_item);
  }
  running_.store(false, std::memory_order_release);
  if (error) std::rethrow_exception(error);
}

ThreadPool::Cost& ThreadPool::cost_of(LoopWork::Body body) noexcept {
  for (Cost& cost : costs_) {
    if (cost.body == body) return cost;
  }
  Cost& cost = costs_[next_cost_++ % kMaxCosts];
  cost = {body, -1};
  return cost;
}

// A single range is not worth another thread, nor is a short loop.
int ThreadPool::workers_for(const LoopWork& work, const Cost& cost) const noexcept {
  if (workers_ == nullptr || work.items <= work.chunk) return 1;
  const int most = std::min(threads_, workers_->helpers() + 1);
  if (cost.per_item < 0) return most;
  const double paid = cost.per_item * work.items / kMinShare;
  return static_cast<int>(std::clamp(paid, 1.0, static_cast<double>(most)));
}

}  // namespace engram
