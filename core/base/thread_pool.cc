#include "core/base/thread_pool.h"

#include <algorithm>
#include <string>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "core/base/ieee_scope.h"

namespace engram {
namespace {

// Polls before sleeping in the kernel: some ten microseconds, about the pause between two loops of
// a busy batch.
constexpr int kSpins = 500;

void relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Returns once `value` differs from `old`.
void wait_for_change(const std::atomic<std::uint32_t>& value, std::uint32_t old) noexcept {
  for (int i = 0; i < kSpins; ++i) {
    if (value.load(std::memory_order_acquire) != old) return;
    relax();
  }
  value.wait(old);
}

}  // namespace

ThreadPool::ThreadPool(int threads) {
  if (threads < 1 || threads > kMaxThreads) {
    throw Error(Error::kInvalidArgument, "number of threads is " + std::to_string(threads) +
                                             "; allowed are 1 to " + std::to_string(kMaxThreads));
  }
  workers_.reserve(static_cast<std::size_t>(threads - 1));
  try {
    for (int worker = 1; worker < threads; ++worker) {
      workers_.emplace_back([this, worker] { serve(worker); });
    }
  } catch (const std::exception& error) {
    // Out of threads, or of memory for one.
    stop();
    throw Error(Error::kUnavailable, "number of threads is " + std::to_string(threads) +
                                         "; the system allows " + std::to_string(this->threads()) +
                                         " (" + error.what() + ")");
  }
}

ThreadPool::~ThreadPool() { stop(); }

void ThreadPool::stop() noexcept {
  stopping_ = true;
  generation_.fetch_add(1);
  generation_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::run_loop(const Loop& loop) {
  if (loop.items < 0 || loop.chunk < 1) {
    throw Error(Error::kInvalidArgument, "loop over " + std::to_string(loop.items) +
                                             " items in chunks of " + std::to_string(loop.chunk) +
                                             "; allowed are items >= 0 and chunk >= 1");
  }
  if (busy_.exchange(true, std::memory_order_acquire)) {
    throw Error(Error::kBadState,
                "this thread pool is running a loop; loops cannot nest or overlap");
  }

  const IeeeScope scope;

  // Publish the loop, work along, and wait for the others: each of them must have seen the end of
  // this loop before the next one may overwrite it.
  loop_ = loop;
  next_.store(0, std::memory_order_relaxed);
  const bool shared = is_shared(loop);
  if (shared) {
    pending_.store(static_cast<std::uint32_t>(workers_.size()), std::memory_order_relaxed);
    generation_.fetch_add(1);
    generation_.notify_all();
  }
  work(0);
  if (shared) {
    while (const std::uint32_t left = pending_.load(std::memory_order_acquire)) {
      wait_for_change(pending_, left);
    }
  }

  const std::exception_ptr error = std::exchange(error_, nullptr);
  busy_.store(false, std::memory_order_release);
  if (error) std::rethrow_exception(error);
}

// A single range is not worth waking another thread.
bool ThreadPool::is_shared(const Loop& loop) const noexcept {
  return !workers_.empty() && loop.items > loop.chunk;
}

// Length of the range that begins there: at most half of every worker's share of what is left.
int ThreadPool::length_at(const Loop& loop, int begin) const noexcept {
  const int left = loop.items - begin;
  if (!is_shared(loop)) return std::min(loop.chunk, left);
  return std::clamp(left / (2 * threads()), 1, loop.chunk);
}

// Claims and runs ranges of the current loop until none is left.
void ThreadPool::work(int worker) noexcept {
  const Loop loop = loop_;
  int begin = next_.load(std::memory_order_relaxed);
  for (;;) {
    int end = 0;
    do {
      if (begin >= loop.items) return;
      end = begin + length_at(loop, begin);
    } while (!next_.compare_exchange_weak(begin, end, std::memory_order_relaxed));
    try {
      loop.body(loop.context, worker, begin, end);
    } catch (...) {
      const std::lock_guard lock(error_mutex_);
      if (!error_ || begin < error_begin_) {
        error_ = std::current_exception();
        error_begin_ = begin;
      }
    }
    begin = next_.load(std::memory_order_relaxed);
  }
}

// Main loop of a worker other than the caller.
void ThreadPool::serve(int worker) noexcept {
  const IeeeScope scope;  // a new thread has the mode of the one that starts it
  for (std::uint32_t seen = 0;; ++seen) {
    wait_for_change(generation_, seen);
    if (stopping_) return;
    work(worker);
    if (pending_.fetch_sub(1) == 1) pending_.notify_one();
  }
}

}  // namespace engram
