#include "protocol/parallel/worker_pool.h"

#include <string>
#include <utility>

#include "core/base/error.h"

namespace engram {

WorkerPool::WorkerPool(int threads, const WorkFunction& work) : work_(work) {
  try {
    for (int worker = 0; worker < threads; ++worker) {
      threads_.emplace_back([this, worker] { run_worker(worker); });
    }
  } catch (const std::exception& error) {
    shut_down();
    throw Error(Error::kUnavailable,
                "threads: " + std::to_string(threads) + " given, the system allows " +
                    std::to_string(threads_.size()) + " (" + error.what() + ")");
  }
}

WorkerPool::~WorkerPool() { shut_down(); }

void WorkerPool::start(std::uint64_t number, const WorkItem& item) {
  const std::lock_guard lock(mutex_);
  stops_.try_emplace(number, std::make_unique<std::atomic<bool>>(false));
  // So that no thread ever runs out of memory for its last report.
  reports_.reserve(reports_.size() + stops_.size());
  queue_.push_back({number, item});
  queued_.notify_one();
}

void WorkerPool::stop(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  if (const auto found = stops_.find(number); found != stops_.end()) *found->second = true;
}

std::vector<WorkReport> WorkerPool::wait(std::chrono::milliseconds at_most) {
  std::unique_lock lock(mutex_);
  reported_.wait_for(lock, at_most, [this] { return !reports_.empty(); });
  std::vector<WorkReport> taken;
  taken.reserve(stops_.size());
  taken.swap(reports_);
  for (const WorkReport& report : taken) {
    if (report.finished) stops_.erase(report.number);
  }
  return taken;
}

void WorkerPool::emit(std::uint64_t number, Bytes result) {
  const std::lock_guard lock(mutex_);
  reports_.reserve(reports_.size() + 1 + stops_.size());
  reports_.push_back({.number = number, .result = std::move(result)});
  reported_.notify_one();
}

void WorkerPool::shut_down() {
  {
    const std::lock_guard lock(mutex_);
    shutting_down_ = true;
    for (const auto& [number, stopped] : stops_) *stopped = true;
    queued_.notify_all();
  }
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::run_worker(int worker) {
  std::unique_lock lock(mutex_);
  while (true) {
    queued_.wait(lock, [this] { return shutting_down_ || !queue_.empty(); });
    if (shutting_down_) return;
    const QueuedItem next = queue_.front();
    queue_.pop_front();
    const std::atomic<bool>& stopped = *stops_.at(next.number);
    lock.unlock();
    WorkReport last{.number = next.number, .finished = true};
    try {
      const WorkContext::Emit take = [this, &next](Bytes result) {
        emit(next.number, std::move(result));
      };
      if (!stopped) work_(next.item, WorkContext(worker, stopped, env_steps_, &take));
    } catch (...) {
      last.error = std::current_exception();
    }
    lock.lock();
    reports_.push_back(std::move(last));
    reported_.notify_one();
  }
}

}  // namespace engram
