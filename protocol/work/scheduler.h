// Work spread over the threads of one or more processes, piece by piece.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>

#include "protocol/formats/bytes.h"
#include "protocol/work/ranks.h"

namespace engram {

// A piece of work: episodes of one task with consecutive seeds.
struct WorkItem {
  int task = 0;  // a number that source and worker agree on
  std::uint64_t first_seed = 0;
  int count = 0;
};

// How a thread that works on an item learns that it should stop, and reports progress.
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

struct WorkStatus {
  std::uint64_t env_steps = 0;  // of all ranks, a moment ago
  int under_way = 0;            // items
};

// Hands out work and takes results; lives on rank 0 and is called by one thread alone. Whatever it
// throws ends the run.
class WorkSource {
 public:
  virtual ~WorkSource() = default;
  // The next item, the longest work first; nullopt if there is none at the moment. The run is over
  // when there is none and no item is under way.
  virtual std::optional<WorkItem> next() = 0;
  // Takes the result of an item. Results come in any order.
  virtual void accept(const WorkItem& item, Bytes result) = 0;
  // Whether the result of an item under way is no longer needed; then it is stopped, not accepted.
  virtual bool obsolete(const WorkItem& /*item*/) { return false; }
  // Several times a second.
  virtual void tick(const WorkStatus& /*status*/) {}
};

// How many threads `threads` stands for; 0: one per core, shared among this machine's ranks.
int worker_threads(int threads, const Ranks& ranks);

// Runs all work of the source on `threads` threads of every rank, each with one item at a time.
// All ranks call it; only rank 0's source is used. The first failure of a worker, on any rank,
// stops the other threads of rank 0 and is thrown there; the caller says so and calls Ranks::abort.
void share_work(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source);

}  // namespace engram
