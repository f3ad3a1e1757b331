#include "bench/bit_identity.h"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/error.h"
#include "tests/core/batch/scene_task.h"

namespace engram::bench {
namespace {

using test::SceneTask;

// Pairs of two properties that occur in configurations.
template <class First, class Second>
auto pairs_of(First first, Second second, bool alone = true) {
  std::set<std::pair<int, int>> pairs;
  for (const RunConfig& config : run_configs()) {
    if (alone || config.num_envs > 1) pairs.insert({config.*first, config.*second});
  }
  return pairs;
}

TEST_CASE("The configurations hold every pair of threads, chunk, batch size and order",
          "[bit_identity]") {
  CHECK(pairs_of(&RunConfig::threads, &RunConfig::chunk, false).size() == 5 * 3);
  CHECK(pairs_of(&RunConfig::threads, &RunConfig::num_envs, false).size() == 5 * 2);
  CHECK(pairs_of(&RunConfig::threads, &RunConfig::shuffled, false).size() == 5 * 2);
  CHECK(pairs_of(&RunConfig::chunk, &RunConfig::num_envs).size() == 3 * 3);
  CHECK(pairs_of(&RunConfig::chunk, &RunConfig::shuffled).size() == 3 * 2);
  CHECK(pairs_of(&RunConfig::num_envs, &RunConfig::shuffled).size() == 3 * 2);
}

// Checks a task of 20 steps with the robot alone, changed by `change`.
template <class Change>
IdentityResult check_changed(const Change& change, std::uint64_t seed = 0) {
  IdentityOptions options;
  options.steps = 4;
  options.seed = seed;
  options.make_batch = [&change]([[maybe_unused]] InstructionSet set, const std::string&,
                                 const BatchOptions& env_options) {
    auto task = std::make_unique<SceneTask>();
    task->description.horizon = 20;
    if constexpr (std::is_invocable_v<Change, SceneTask&, InstructionSet>) {
      change(*task, set);
    } else {
      change(*task);
    }
    return std::make_unique<Batch>(std::move(task), env_options);
  };
  return check_identity("SceneTask", options);
}

IdentityResult check_unchanged(std::uint64_t seed = 0) {
  return check_changed([](SceneTask&) {}, seed);
}

TEST_CASE("A deterministic task has no differences", "[bit_identity]") {
  const IdentityResult result = check_unchanged();
  CHECK(result.different == 0);
  CHECK(result.runs == 18);
  // The batches of 7 are filled up with 5 segments; 16 episodes run to step 18.
  const auto sevens = std::count_if(run_configs().begin(), run_configs().end(),
                                    [](const RunConfig& config) { return config.num_envs == 7; });
  CHECK(result.env_steps == 4 * (18 * 128 + 5 * sevens) + 16 * 18);
  CHECK(result.episodes >= 18 * 16);  // those that run past their end
  CHECK(check_unchanged().fingerprint == result.fingerprint);
  CHECK(check_unchanged(64).fingerprint != result.fingerprint);
}

TEST_CASE("A dependence on the slot is found", "[bit_identity]") {
  const IdentityResult result = check_changed(
      [](SceneTask& task) { task.reward = [](int env) { return env == 3 ? 1e-30F : 0.0F; }; });
  CHECK(result.different > 0);
  CHECK(result.fingerprint != check_unchanged().fingerprint);
}

TEST_CASE("A dependence on the order of work is found", "[bit_identity]") {
  std::atomic<int> calls = 0;
  const IdentityResult result = check_changed([&calls](SceneTask& task) {
    task.reward = [&calls](int) { return static_cast<float>(calls.fetch_add(1)); };
  });
  CHECK(result.different > 0);
}

TEST_CASE("A dependence on the instruction set is found", "[bit_identity]") {
  const IdentityResult result = check_changed([](SceneTask& task, InstructionSet set) {
    const bool baseline = set == InstructionSet::kBaseline;
    task.reward = [baseline](int) { return baseline ? 1e-30F : 0.0F; };
  });
  CHECK(result.different > 0);
  CHECK(result.fingerprint == check_unchanged().fingerprint);
}

// A task that stores its slot in memory, without an output of it.
TEST_CASE("A difference in memory alone is found", "[bit_identity]") {
  const IdentityResult result = check_changed([](SceneTask& task) {
    task.on_reset = [&task](int env) {
      const ColumnView column = task.engine.memory->find("action");
      reinterpret_cast<float*>(column.row(env))[6] = env == 2 ? 1.0F : 0.0F;
    };
  });
  CHECK(result.different > 0);
  CHECK(result.fingerprint == check_unchanged().fingerprint);
}

TEST_CASE("Real tasks show the same bits in every configuration", "[bit_identity]") {
  IdentityOptions options;
  options.steps = 5;
  double last = 0;
  options.progress = [&last](double fraction) {
    CHECK(fraction > last);
    last = fraction;
  };
  const IdentityResult state = check_identity("InterceptGrabFast-VLA-v0", options);
  CHECK(state.different == 0);
  CHECK(state.episodes > 0);
  CHECK(last == 1);
  last = 0;
  options.steps = 1;
  options.obs_mode = ObsMode::kRgb;
  const IdentityResult rgb = check_identity("RememberColor3-VLA-v0", options);
  CHECK(rgb.different == 0);
  CHECK_THROWS_AS(check_identity("Nothing-VLA-v0", options), Error);
}

}  // namespace
}  // namespace engram::bench
