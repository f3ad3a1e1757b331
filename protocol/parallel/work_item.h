// Items of work, and the function that works on them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

#include "protocol/io/bytes.h"

namespace engram {

// An item of work: episodes of one task with consecutive seeds.
struct WorkItem {
  int task = 0;  // a number that source and worker agree on
  std::uint64_t first_seed = 0;
  int count = 0;
  int repeat = 0;  // how often the episodes have been asked for before
};

// Stop request, results and progress of a thread that works on an item.
class WorkContext {
 public:
  using Emit = std::function<void(Bytes result)>;

  // emit: takes the item's results one by one; nothing: they are dropped. It outlives this object.
  WorkContext(int worker, const std::atomic<bool>& stopped, std::atomic<std::uint64_t>& env_steps,
              const Emit* emit = nullptr)
      : worker_(worker), stopped_(&stopped), env_steps_(&env_steps), emit_(emit) {}

  // 0 to threads - 1, in this process.
  int worker() const { return worker_; }
  // The results are no longer wanted: return at once.
  bool stopped() const { return stopped_->load(std::memory_order_relaxed); }
  // Hands over a result, such as that of an episode, as soon as it is known.
  void emit(Bytes result) const {
    if (emit_ != nullptr) (*emit_)(std::move(result));
  }
  // For the progress display.
  void count_env_steps(std::uint64_t steps) const {
    env_steps_->fetch_add(steps, std::memory_order_relaxed);
  }

 private:
  int worker_;
  const std::atomic<bool>* stopped_;
  std::atomic<std::uint64_t>* env_steps_;
  const Emit* emit_;
};

// Works on one item and emits its results. Runs on several threads at once, on every rank.
using WorkFunction = std::function<void(const WorkItem&, const WorkContext&)>;

}  // namespace engram
