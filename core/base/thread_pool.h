// Parallel loops over the environments of a batch.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>
#include <type_traits>
#include <vector>

namespace engram {

// A fixed set of threads that share loops. The calling thread works too, as worker 0, so a pool of
// one thread starts none and runs every loop inline.
class ThreadPool {
 public:
  static constexpr int kMaxThreads = 1024;

  // threads: 1 to kMaxThreads, the caller included. Throws Error if it is out of range
  // (kInvalidArgument) or if the system refuses a thread (kUnavailable).
  explicit ThreadPool(int threads);
  ~ThreadPool();

  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int threads() const noexcept { return static_cast<int>(workers_.size()) + 1; }

  // Calls f(worker, begin, end) for neighbouring ranges of [0, items), each range once, on
  // whichever worker is free (0 <= worker < threads()), and returns when all are done. Every call
  // of f computes in an IeeeScope. Does not allocate.
  //
  // Ranges have `chunk` items. If several threads share a loop, its last ranges get shorter and
  // shorter, so that no thread waits long for the last one. The ranges depend on items, chunk and
  // threads() alone.
  //
  // If f throws, the other ranges are still run. Then the exception of the lowest range is
  // rethrown, so that the outcome does not depend on which worker was free.
  //
  // Throws Error if items < 0 or chunk < 1 (kInvalidArgument), or if a loop is running already
  // (kBadState): loops neither nest nor overlap.
  template <typename F>
  void run(int items, int chunk, F&& f) {
    using Function = std::remove_reference_t<F>;
    const Body body = [](const void* context, int worker, int begin, int end) {
      (*static_cast<Function*>(const_cast<void*>(context)))(worker, begin, end);
    };
    run_loop({body, std::addressof(f), items, chunk});
  }

 private:
  using Body = void (*)(const void* context, int worker, int begin, int end);

  struct Loop {
    Body body = nullptr;
    const void* context = nullptr;  // the function object, const or not as the caller gave it
    int items = 0;
    int chunk = 1;
  };

  void run_loop(const Loop& loop);
  bool is_shared(const Loop& loop) const noexcept;
  int length_at(const Loop& loop, int begin) const noexcept;
  void work(int worker) noexcept;
  void serve(int worker) noexcept;
  void stop() noexcept;

  std::vector<std::thread> workers_;
  Loop loop_;              // written by the caller between loops only
  bool stopping_ = false;  // likewise
  std::atomic<bool> busy_ = false;

  std::mutex error_mutex_;
  std::exception_ptr error_;  // of the lowest range that failed
  int error_begin_ = 0;

  // On cache lines of their own: what every worker polls, claims from and reports to.
  alignas(64) std::atomic<std::uint32_t> generation_ = 0;  // number of loops started
  alignas(64) std::atomic<int> next_ = 0;                  // first item not yet claimed
  alignas(64) std::atomic<std::uint32_t> pending_ = 0;     // workers not yet done with the loop
};

}  // namespace engram
