// The process's threads that help with parallel loops. All thread pools share them.
#pragma once

#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

#include "core/threads/shared_loop.h"

namespace engram {

class WorkerThreads {
 public:
  static constexpr int kMaxThreads = 1024;

  // Starts `helpers` threads, 0 to kMaxThreads - 1. Throws Error if it is out of range
  // (kInvalidArgument) or if the system refuses a thread (kUnavailable).
  explicit WorkerThreads(int helpers);
  // No loop is running.
  ~WorkerThreads();

  WorkerThreads(const WorkerThreads&) = delete;
  WorkerThreads& operator=(const WorkerThreads&) = delete;

  // Threads of this process: one fewer than its usable processors, since a loop's caller works too.
  // They start with the first pool and end with the last one. A child of fork() gets its own.
  static std::shared_ptr<WorkerThreads> of_process();

  int helpers() const noexcept { return static_cast<int>(threads_.size()); }

  // Runs a loop; returns the exception of the lowest range that failed, or null. `busy`: time of
  // all threads in the loop's body, ns.
  std::exception_ptr run(const LoopWork& work, std::int64_t* busy) noexcept;

 private:
  // Loops of at most that many callers are shared at once. Others run on their own thread alone.
  static constexpr int kMaxLoops = 64;

  SharedLoop* take_place() noexcept;
  void wake(int helpers) noexcept;
  // Works on the open loop that has the fewest threads. True if a range was run.
  bool help() noexcept;
  void serve() noexcept;
  void stop() noexcept;
  bool forked() const noexcept;

  std::array<SharedLoop, kMaxLoops> loops_;
  std::atomic<int> places_ = 0;  // that have ever been taken
  std::atomic<bool> stopping_ = false;
  alignas(64) std::atomic<std::uint32_t> opened_ = 0;  // number of loops; what idle threads watch
  std::vector<std::thread> threads_;
  pid_t owner_;
};

}  // namespace engram
