// Rule sets of tasks. tools/surface writes the enum from api/surface.toml.
#pragma once

#include <array>

namespace engram {

// begin generated: enum
// Rule set of a task, where the original's code differs from what it is meant to do.
enum class Rules {
  kReference,  // engram's own, which follow the benchmark's documentation
  kOriginal,   // the original's code, as far as a task option can express it
};
inline constexpr std::array kRulesNames = {"reference", "original"};
constexpr const auto& names_of(Rules) { return kRulesNames; }
// end generated

}  // namespace engram
