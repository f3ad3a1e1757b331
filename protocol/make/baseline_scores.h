// Measured scores of policies without memory in the benchmark's tasks (docs/memory.md).
#pragma once

#include <optional>
#include <string_view>

namespace engram {

// Shares of 200 episodes, for the default rules.
struct BaselineScores {
  std::string_view id;
  // Success in any step.
  double blind = 0;
  double sweep = 0;
  double oracle = 0;
  // Right first answers; negative where the task asks for none.
  double blind_answer = -1;
  double sweep_answer = -1;
  double oracle_answer = -1;
};

// Scores of a task of the benchmark; null for users' variants.
const BaselineScores* find_baseline_scores(std::string_view id) noexcept;

// Position of a success rate between that of the best policy without memory, 0, and the
// oracle's, 1; at least -1. Nothing where both are nearly the same.
std::optional<double> memory_score(const BaselineScores& baseline, double success_rate) noexcept;

}  // namespace engram
