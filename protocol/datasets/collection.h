// Collecting demonstrations of several tasks with all threads of all processes.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "protocol/datasets/demonstration_folder.h"
#include "protocol/parallel/ranks.h"
#include "protocol/parallel/run_header.h"

namespace engram {

struct CollectionOptions {
  CollectionPlan plan;        // of every task
  std::filesystem::path out;  // holds data_npz/<id>
  // Takes the demonstrations, not compressed, instead of a folder; of one task only.
  DemonstrationSink sink = {};
  int num_envs = 10;  // environments that a thread steps together, at most
  int threads = 0;
};

struct CollectionProgress {
  int episodes = 0;  // kept, of all tasks
  int wanted = 0;
  int added = 0;                // in this run
  std::uint64_t env_steps = 0;  // played in this run, failed episodes included
};

// The header of a shard's journal. A shard plays the share of the
// attempts that are needed where all succeed.
RunHeader shard_header(std::span<const RegistryEntry* const> tasks, const CollectionPlan& plan,
                       const EpisodePart& part);
// The folder of a shard's task, below that of the shard.
std::filesystem::path shard_task_folder(const std::filesystem::path& shard,
                                        const RegistryEntry& task);

// Plays the share that the header says, into the shard's folder. All ranks call it; rank 0 alone
// has a journal.
void collect_shard(Ranks& ranks, std::span<const RegistryEntry* const> tasks,
                   const CollectionOptions& options, const std::filesystem::path& folder,
                   const RunHeader& header, Journal* journal,
                   const std::function<void(const CollectionProgress&)>& progress);

// Opens or makes the folder of every task and plays what is missing. The files do not depend on
// threads, environments or ranks. All ranks call it; rank 0 alone touches files and gets the
// folders, in the order of the tasks, finished. Throws Error as DemonstrationFolder does.
std::vector<std::unique_ptr<DemonstrationFolder>> collect(
    Ranks& ranks, std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
    const std::function<void(const CollectionProgress&)>& progress);

}  // namespace engram
