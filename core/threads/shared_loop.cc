#include "core/threads/shared_loop.h"

#include <algorithm>
#include <utility>

#include "core/threads/spin_wait.h"

namespace engram {

void SharedLoop::open(const LoopWork& work) noexcept {
  ++number_;
  body_.store(work.body, std::memory_order_relaxed);
  context_.store(work.context, std::memory_order_relaxed);
  items_.store(work.items, std::memory_order_relaxed);
  chunk_.store(work.chunk, std::memory_order_relaxed);
  unit_.store(work.unit, std::memory_order_relaxed);
  workers_.store(work.workers, std::memory_order_relaxed);
  busy_ns_.store(0, std::memory_order_relaxed);
  left_.store(static_cast<std::uint32_t>(work.items), std::memory_order_relaxed);
  joined_.store(Tagged{number_, 1}.word(), std::memory_order_relaxed);
  claim_.store(Tagged{number_, 0}.word(), std::memory_order_release);
}

std::exception_ptr SharedLoop::finish(std::int64_t* busy) noexcept {
  work(number_, 0);
  SpinWait spin;
  while (const std::uint32_t left = left_.load(std::memory_order_acquire)) {
    if (!spin.poll()) left_.wait(left, std::memory_order_acquire);
  }
  *busy = busy_ns_.load(std::memory_order_relaxed);
  return std::exchange(error_, nullptr);
}

int SharedLoop::workers_if_open() const noexcept {
  const Tagged next = Tagged::of(claim_.load(std::memory_order_acquire));
  if (next.count >= static_cast<std::uint32_t>(items_.load(std::memory_order_relaxed))) return 0;
  const Tagged joined = Tagged::of(joined_.load(std::memory_order_relaxed));
  const auto most = static_cast<std::uint32_t>(workers_.load(std::memory_order_relaxed));
  return joined.number == next.number && joined.count < most ? static_cast<int>(joined.count) : 0;
}

bool SharedLoop::help() noexcept {
  const std::uint32_t number = Tagged::of(claim_.load(std::memory_order_acquire)).number;
  std::uint64_t word = joined_.load(std::memory_order_relaxed);
  for (;;) {
    const Tagged joined = Tagged::of(word);
    const auto most = static_cast<std::uint32_t>(workers_.load(std::memory_order_relaxed));
    if (joined.number != number || joined.count >= most) return false;
    const std::uint64_t with_me = Tagged{number, joined.count + 1}.word();
    if (joined_.compare_exchange_weak(word, with_me, std::memory_order_relaxed)) {
      return work(number, static_cast<int>(joined.count));
    }
  }
}

// The loop's numbers are valid once a range is claimed: a loop does not end before that range is
// done.
bool SharedLoop::claim(std::uint32_t number, Range* range) noexcept {
  std::uint64_t word = claim_.load(std::memory_order_acquire);
  for (;;) {
    const Tagged next = Tagged::of(word);
    const int items = items_.load(std::memory_order_relaxed);
    const int begin = static_cast<int>(next.count);
    if (next.number != number || begin >= items) return false;
    // At most half of every worker's share of what is left, in whole units.
    const int unit = unit_.load(std::memory_order_relaxed);
    const int left = items - begin;
    const int share = left / (2 * workers_.load(std::memory_order_relaxed));
    const int whole = std::max(share - share % unit, unit);
    const int end = begin + std::min({whole, chunk_.load(std::memory_order_relaxed), left});
    const std::uint64_t after = Tagged{number, static_cast<std::uint32_t>(end)}.word();
    if (claim_.compare_exchange_weak(word, after, std::memory_order_acq_rel,
                                     std::memory_order_acquire)) {
      *range = {begin, end};
      return true;
    }
  }
}

bool SharedLoop::work(std::uint32_t number, int worker) noexcept {
  Range range;
  if (!claim(number, &range)) return false;
  do {
    run(worker, range);
  } while (claim(number, &range));
  return true;
}

void SharedLoop::run(int worker, const Range& range) noexcept {
  const std::int64_t start = now_ns();
  try {
    body_.load(std::memory_order_relaxed)(context_.load(std::memory_order_relaxed), worker,
                                          range.begin, range.end);
  } catch (...) {
    const std::lock_guard lock(error_mutex_);
    if (!error_ || range.begin < error_begin_) {
      error_ = std::current_exception();
      error_begin_ = range.begin;
    }
  }
  busy_ns_.fetch_add(now_ns() - start, std::memory_order_relaxed);
  const auto done = static_cast<std::uint32_t>(range.end - range.begin);
  if (left_.fetch_sub(done, std::memory_order_acq_rel) == done) left_.notify_one();
}

}  // namespace engram
