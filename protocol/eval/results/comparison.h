// Two policies on the same episodes: `engram compare`.
#pragma once

#include <array>
#include <set>
#include <string_view>

#include "core/base/names.h"
#include "protocol/eval/results/result_set.h"

namespace engram {

// Differences between two results that the user may allow.
enum class AllowedDifference {
  kIds,    // tasks of one of them are left out
  kSeeds,  // so are episodes of one of them
  kVersion,
  kRules,
  kConstants,  // task options and perturbations
  kChoices,    // one policy names answers, the other acts
  kPhysics,    // and versions of MuJoCo
};
inline constexpr std::array kAllowedDifferenceNames = {"ids",       "seeds",   "version", "rules",
                                                       "constants", "choices", "physics"};
constexpr const auto& names_of(AllowedDifference) { return kAllowedDifferenceNames; }

// {a, b, tasks, splits, total}; docs/evaluation.md has the keys. Throws Error (kInvalidArgument)
// unless the episodes pair by id and seed, and are those of the same environments.
Json compare_results(const ResultSet& a, const ResultSet& b,
                     const std::set<AllowedDifference>& allowed);

}  // namespace engram
