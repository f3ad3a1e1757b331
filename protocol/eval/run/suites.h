// Named lists of tasks and episodes that results are published on.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/io/json.h"

namespace engram {

struct Suite {
  std::string_view name;
  std::span<const std::string_view> ids;
  int episodes;  // per task, from kBenchmarkSeed on
};

// Throws Error (kInvalidArgument) for an unknown name. `option`: for the message.
const Suite& require_suite(std::string_view option, std::string_view name);
// The names, for messages and help: "mikasa5|...".
std::string suite_names();
// {name: {ids, episodes, seed}}.
Json suites_document();

}  // namespace engram
