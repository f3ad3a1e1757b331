// Checks that files of a folder are results of an evaluation.
#pragma once

#include <optional>

#include "protocol/eval/run/settings.h"

namespace engram {

// The result in a task's document; nothing if the document is not one, or lacks a field that is
// read later.
std::optional<TaskResult> parse_result(const Json& document, const RegistryEntry& entry);

// True if the result has the episodes and seeds of these settings, none of them longer than the
// task allows.
bool follows_protocol(const TaskResult& result, const EvaluationSettings& settings);

}  // namespace engram
