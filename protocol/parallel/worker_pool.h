// The threads of one process that work on items one by one.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "protocol/io/bytes.h"
#include "protocol/parallel/work_item.h"

namespace engram {

// What a thread has to say of its item: a result, or that there will be no more.
struct WorkReport {
  std::uint64_t number = 0;
  bool finished = false;
  Bytes result = {};
  std::exception_ptr error = nullptr;  // of an item that has failed
};

class WorkerPool {
 public:
  // Throws Error (kUnavailable) if the system does not allow that many threads.
  WorkerPool(int threads, const WorkFunction& work);
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  std::uint64_t env_steps() const { return env_steps_.load(std::memory_order_relaxed); }

  void start(std::uint64_t number, const WorkItem& item);
  // Asks the thread that works on that item to return.
  void stop(std::uint64_t number);
  // Reports since the last call, those of an item in their order. If there are none, waits for one,
  // but not longer than `at_most`.
  std::vector<WorkReport> wait(std::chrono::milliseconds at_most);

 private:
  struct QueuedItem {
    std::uint64_t number;
    WorkItem item;
  };

  void run_worker(int worker);
  void emit(std::uint64_t number, Bytes result);
  void shut_down();

  const WorkFunction& work_;
  std::vector<std::thread> threads_;
  std::atomic<std::uint64_t> env_steps_ = 0;

  std::mutex mutex_;
  std::condition_variable queued_;
  std::condition_variable reported_;
  bool shutting_down_ = false;
  std::deque<QueuedItem> queue_;
  std::vector<WorkReport> reports_;
  std::map<std::uint64_t, std::unique_ptr<std::atomic<bool>>> stops_;
};

}  // namespace engram
