// `engram collect`: demonstrations to learn from.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "apps/command_line.h"
#include "protocol/datasets/collection.h"
#include "protocol/datasets/collection_report.h"

namespace engram::apps {

// task_options: as in apps/play_command.h.
void add_collect_command(const Command& program,
                         const std::shared_ptr<const std::vector<std::string>>& task_options);

// Writes the report of a collection that has ended, and prints what it has. Throws Error
// (kUnavailable) if episodes are missing.
void report_collection(const std::vector<std::unique_ptr<DemonstrationFolder>>& folders,
                       const CollectionOptions& collection, const CollectionTiming& timing,
                       bool json);

}  // namespace engram::apps
