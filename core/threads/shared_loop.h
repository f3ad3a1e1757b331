// One parallel loop that several threads work on.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>

namespace engram {

// Calls body(context, worker, begin, end) for neighbouring ranges of [0, items), each range once.
struct LoopWork {
  using Body = void (*)(const void* context, int worker, int begin, int end);

  Body body = nullptr;
  const void* context = nullptr;  // the function object, const or not as the caller gave it
  int items = 0;
  int chunk = 1;    // longest range
  int unit = 1;     // ranges are multiples of it, but for the last one; not above chunk
  int workers = 1;  // most threads, the caller's included
};

// A place for loops, one after the other. Ranges are claimed by a compare-and-swap on one word that
// holds the loop's number and the next item: a late thread gets no range, and no thread waits for
// him. A loop ends when its items are done, not when every thread has seen it.
class SharedLoop {
 public:
  // --- the calling thread ---

  // Takes the place, if it is free.
  bool take() noexcept { return !taken_.exchange(true, std::memory_order_acquire); }
  void release() noexcept { taken_.store(false, std::memory_order_release); }
  // Opens a loop to others.
  void open(const LoopWork& work) noexcept;
  // Works along as worker 0 and waits for the ranges of others. Returns the exception of the lowest
  // range that failed, or null; busy time of all workers in *busy, ns.
  std::exception_ptr finish(std::int64_t* busy) noexcept;

  // --- others ---

  // Threads at work on an open loop that takes another one; 0 if there is none.
  int workers_if_open() const noexcept;
  // Works along, if the loop takes another thread. True if a range was run.
  bool help() noexcept;

 private:
  // A loop's number and a count, in one word.
  struct Tagged {
    std::uint32_t number = 0;
    std::uint32_t count = 0;
    static Tagged of(std::uint64_t word) noexcept {
      return {static_cast<std::uint32_t>(word >> 32), static_cast<std::uint32_t>(word)};
    }
    std::uint64_t word() const noexcept { return std::uint64_t{number} << 32 | count; }
  };
  struct Range {
    int begin = 0;
    int end = 0;
  };

  bool claim(std::uint32_t number, Range* range) noexcept;
  // Runs ranges of the loop with this number until none is left. True if it ran one.
  bool work(std::uint32_t number, int worker) noexcept;
  void run(int worker, const Range& range) noexcept;

  std::atomic<bool> taken_ = false;
  std::uint32_t number_ = 0;  // of the present loop; the calling thread's

  // The loop. Written between loops; late threads may read them at any time.
  std::atomic<LoopWork::Body> body_ = nullptr;
  std::atomic<const void*> context_ = nullptr;
  std::atomic<int> items_ = 0;
  std::atomic<int> chunk_ = 1;
  std::atomic<int> unit_ = 1;
  std::atomic<int> workers_ = 1;

  std::mutex error_mutex_;
  std::exception_ptr error_;  // of the lowest range that failed
  int error_begin_ = 0;

  // On cache lines of their own: what every worker claims from and reports to.
  alignas(64) std::atomic<std::uint64_t> claim_ = 0;   // Tagged: first item not yet claimed
  alignas(64) std::atomic<std::uint64_t> joined_ = 0;  // Tagged: threads that have joined
  alignas(64) std::atomic<std::uint32_t> left_ = 0;    // items not yet done
  std::atomic<std::int64_t> busy_ns_ = 0;
};

}  // namespace engram
