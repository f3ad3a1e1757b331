// Scheduling of work items on the threads of one or more processes.
#pragma once

#include <cstdint>
#include <optional>

#include "protocol/io/bytes.h"
#include "protocol/parallel/ranks.h"
#include "protocol/parallel/work_item.h"

namespace engram {

struct WorkStatus {
  std::uint64_t env_steps = 0;  // of all ranks, a moment ago
  int in_progress = 0;          // items
};

// Source of items and sink of results, on rank 0. Called by one thread. An exception of it ends the
// run.
class WorkSource {
 public:
  virtual ~WorkSource() = default;
  // The next item, the longest work first; nullopt if there is none at the moment. The run is over
  // when there is none and no item is in progress.
  virtual std::optional<WorkItem> next() = 0;
  // Takes a result of an item. Those of one item come in its order, items in any order.
  virtual void accept(const WorkItem& item, Bytes result) = 0;
  // True if further results of an item in progress are not needed; then it is stopped, and they are
  // not accepted.
  virtual bool obsolete(const WorkItem& /*item*/) { return false; }
  // Several times a second.
  virtual void tick(const WorkStatus& /*status*/) {}
};

// Number of threads that `threads` means; 0: one per core, shared among this machine's ranks.
int worker_threads(int threads, const Ranks& ranks);

// Runs all work of the source on `threads` threads of every rank, each with one item at a time.
// All ranks call it; only rank 0's source is used. The first failure of a worker, on any rank,
// stops the other threads of rank 0 and is thrown there; the caller reports it and calls
// Ranks::abort.
void distribute_work(Ranks& ranks, int threads, const WorkFunction& work, WorkSource& source);

}  // namespace engram
