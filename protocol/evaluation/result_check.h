// Whether what a folder holds is what an evaluation has written into it.
#pragma once

#include <optional>

#include "protocol/evaluation/settings.h"

namespace engram {

// The result that a task's document tells of; nothing if the document is not one, or lacks
// something that is read of it later.
std::optional<TaskResult> parse_result(const Document& document, const RegistryEntry& entry);

// Whether that many episodes were played with the seeds of these settings, none of them longer than
// the task allows.
bool follows_protocol(const TaskResult& result, const EvaluationSettings& settings);

// What documents carry at their end, so that one that was changed by hand can be told: of all that
// stands before.
std::string document_checksum(const DocumentTable& document);

}  // namespace engram
