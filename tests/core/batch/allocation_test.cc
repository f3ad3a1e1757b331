// Nothing in a step allocates.
#include <mujoco/mujoco.h>

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "core/batch/scripted_policy.h"
#include "tests/allocation_counter.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_running;

std::atomic<int> mujoco_allocations = 0;

void* counted(size_t size) {
  ++mujoco_allocations;
  return std::aligned_alloc(8, (size + 7) / 8 * 8);
}

// Allocations of operator new and of MuJoCo in a loop of steps that the oracle takes, pressing
// down at the end so that there are contacts.
std::int64_t allocations_in_steps(Batch& batch, int steps) {
  std::vector<float> actions = test::zeros(batch);
  const std::int64_t before = test::allocation_count();
  mujoco_allocations = 0;
  mju_user_malloc = counted;
  for (int i = 0; i < steps; ++i) {
    ScriptedPolicy(batch, Policy::kOracle).act(actions);
    for (std::size_t k = 2; k < actions.size(); k += 7) {
      if (i % 25 > 16) actions[k] = -0.5F;
    }
    batch.step(actions);
  }
  mju_user_malloc = nullptr;
  return test::allocation_count() - before + mujoco_allocations;
}

TEST_CASE("Steps do not allocate", "[allocation]") {
  BatchOptions options;
  options.num_envs = 8;
  options.threads = GENERATE(1, 2);
  options.sleep = GENERATE(true, false);
  options.auto_reset = GENERATE(AutoReset::kNextStep, AutoReset::kSameStep);
  for (const char* id : {"RememberColor3-VLA-v0", "RememberColor9-VLA-v0"}) {
    const auto batch = make_running(id, options);
    CHECK(allocations_in_steps(*batch, 60) == 0);  // over two automatic resets
    CHECK(batch->state().episode[0] >= 2);
  }
}

// Without physics, whose scenes are the same for all.
TEST_CASE("No task allocates in steps, automatic resets and policies", "[allocation]") {
  for (const std::string& id : test::implemented_ids()) {
    const auto batch = make_running(id, {.num_envs = 2, .substeps = 0});
    std::vector<float> actions = test::zeros(*batch);
    const std::int64_t before = test::allocation_count();
    while (batch->state().episode[0] < 2) {
      for (const Policy policy : {Policy::kRandom, Policy::kBlind, Policy::kOracle}) {
        ScriptedPolicy(*batch, policy).act(actions);
      }
      batch->step(actions);
    }
    const std::int64_t allocated = test::allocation_count() - before;
    INFO(id);
    CHECK(allocated == 0);
  }
}

TEST_CASE("The counter of allocations counts those of MuJoCo too", "[allocation]") {
  mujoco_allocations = 0;
  mju_user_malloc = counted;
  mju_free(mju_malloc(100));
  mju_user_malloc = nullptr;
  CHECK(mujoco_allocations == 1);
}

TEST_CASE("Steps in every control mode do not allocate", "[allocation]") {
  for (int mode = 0; mode < kControlModes; ++mode) {
    const BatchOptions options{.num_envs = 2, .control_mode = static_cast<ControlMode>(mode)};
    const auto batch = make_running("RememberColor3-VLA-v0", options);
    std::vector<float> actions = test::zeros(*batch);
    const std::int64_t before = test::allocation_count();
    for (int i = 0; i < 30; ++i) {
      ScriptedPolicy(*batch, Policy::kRandom).act(actions);
      batch->step(actions);
    }
    const std::int64_t allocated = test::allocation_count() - before;
    INFO(name_of(*options.control_mode));
    CHECK(allocated == 0);
  }
}

}  // namespace
}  // namespace engram
