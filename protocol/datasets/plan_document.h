// The plan of a collection as JSON, in the journals of its shards.
#pragma once

#include <filesystem>
#include <span>
#include <vector>

#include "protocol/datasets/demonstration_folder.h"

namespace engram {

struct PlannedTasks {
  std::vector<const RegistryEntry*> tasks;
  CollectionPlan plan;
};

Json plan_document(std::span<const RegistryEntry* const> tasks, const CollectionPlan& plan);

// What the document says. file: has it, for messages. Throws Error: kIo if it is none, or of
// another version; kUnknownId or kInvalidArgument where tasks are missing here, or defined in
// another way.
PlannedTasks planned_tasks(const Json& document, const std::filesystem::path& file);

}  // namespace engram
