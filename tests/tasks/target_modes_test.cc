// Modes that track a pose, pushed beyond reach: physics holds.
#include <catch2/catch.hpp>

#include "core/batch/queries.h"
#include "core/sim/action_dim.h"
#include "tasks/family_samples.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

// Every combination of full actions in the components of an action, one for each environment.
std::vector<float> full_actions(int num_envs, int dim) {
  std::vector<float> actions;
  for (int env = 0; env < num_envs; ++env) {
    for (int i = 0; i < dim; ++i) actions.push_back((env >> i & 1) != 0 ? 1.0F : -1.0F);
  }
  return actions;
}

TEST_CASE("Targets beyond reach do not make the physics diverge", "[controller][unstable]") {
  for (const ControlMode mode :
       {ControlMode::kPdEeTargetDeltaPos, ControlMode::kPdEeTargetDeltaPose}) {
    for (const std::string& id : one_of_each_family()) {
      INFO(id << " " << name_of(mode));
      const int dim = action_dim(mode);
      const auto batch = test::make_running(id, {.num_envs = 1 << dim, .control_mode = mode});
      const std::vector<float> actions = full_actions(batch->num_envs(), dim);
      for (int t = 0; t < 120; ++t) batch->step(actions);
      CHECK(Queries(*batch).unstable_count() == 0);
    }
  }
}

}  // namespace
}  // namespace engram
