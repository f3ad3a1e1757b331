// Collecting RL data of several tasks with all threads of all processes.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "protocol/datasets/collection.h"
#include "protocol/datasets/rl_folder.h"
#include "protocol/parallel/ranks.h"

namespace engram {

// Opens or makes the folder of every task and plays the episodes whose files are missing: episode i
// has the plan's first seed + i. The files do not depend on threads, environments or ranks. All
// ranks call it; rank 0 alone touches files and gets the folders, in the order of the tasks.
// Throws Error as RlFolder does.
std::vector<std::unique_ptr<RlFolder>> collect_rl(
    Ranks& ranks, std::span<const RegistryEntry* const> tasks, const CollectionOptions& options,
    const std::function<void(const CollectionProgress&)>& progress);

}  // namespace engram
