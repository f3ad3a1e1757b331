#include "tasks/common/phase_budget.h"

#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram {
namespace {

TEST_CASE("A horizon has to hold all phases and the time to act", "[parts][constants]") {
  CHECK_NOTHROW(tasks::check_horizon(35, {{"CUE_STEPS", 10}, {"EMPTY_STEPS", 5}}, 20));
  CHECK_THROWS_WITH(
      tasks::check_horizon(34, {{"CUE_STEPS", 10}, {"EMPTY_STEPS", 5}}, 20),
      "constants leave no time to act: CUE_STEPS 10 + EMPTY_STEPS 5 + 20 to act = 35 control "
      "steps, more than max_episode_steps 34");
}

}  // namespace
}  // namespace engram
