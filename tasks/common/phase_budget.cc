#include "tasks/common/phase_budget.h"

#include <string>

#include "core/base/error.h"

namespace engram::tasks {

void check_horizon(int horizon, std::initializer_list<PhaseBudget> phases, int min_to_act) {
  int sum = min_to_act;
  std::string words;
  for (const PhaseBudget& phase : phases) {
    sum += phase.steps;
    words += std::string(phase.name) + " " + std::to_string(phase.steps) + " + ";
  }
  if (sum <= horizon) return;
  throw Error(Error::kInvalidArgument,
              "constants leave no time to act: " + words + std::to_string(min_to_act) +
                  " to act = " + std::to_string(sum) +
                  " control steps, more than max_episode_steps " + std::to_string(horizon));
}

}  // namespace engram::tasks
