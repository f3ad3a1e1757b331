// Warnings of a user's constants: those without effect, and those with which the oracle fails.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/batch/batch.h"

namespace engram {

std::vector<std::string> constant_warnings(const TaskInfo& info, const BatchOptions& options);
// Warnings of a task that is to be made.
std::vector<std::string> constant_warnings(std::string_view id, const MakeOptions& options);

}  // namespace engram
