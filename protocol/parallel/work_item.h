// Items of work, and the function that works on them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

#include "protocol/io/bytes.h"

namespace engram {

// An item of work: episodes of one task with consecutive seeds.
struct WorkItem {
  int task = 0;  // a number that source and worker agree on
  std::uint64_t first_seed = 0;
  int count = 0;
  int repeat = 0;  // how often the episodes have been asked for before
};

// Stop request and progress of a thread that works on an item.
class WorkContext {
 public:
  WorkContext(int worker, const std::atomic<bool>& stopped, std::atomic<std::uint64_t>& env_steps)
      : worker_(worker), stopped_(&stopped), env_steps_(&env_steps) {}

  // 0 to threads - 1, in this process.
  int worker() const { return worker_; }
  // The result is no longer wanted: return at once, with anything.
  bool stopped() const { return stopped_->load(std::memory_order_relaxed); }
  // For the progress display.
  void count_env_steps(std::uint64_t steps) const {
    env_steps_->fetch_add(steps, std::memory_order_relaxed);
  }

 private:
  int worker_;
  const std::atomic<bool>* stopped_;
  std::atomic<std::uint64_t>* env_steps_;
};

// Works on one item and returns its result. Runs on several threads at once, on every rank.
using WorkFunction = std::function<Bytes(const WorkItem&, const WorkContext&)>;

}  // namespace engram
