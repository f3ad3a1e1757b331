// The check that the same seeds give the same bits: it finds what it is to find.
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
#include "tests/core/env/scene_task.h"

namespace engram::bench {
namespace {

using test::SceneTask;

// Which pairs of two properties of a play occur.
template <class First, class Second>
auto pairs_of(First first, Second second, bool alone = true) {
  std::set<std::pair<int, int>> pairs;
  for (const Play& play : plays()) {
    if (alone || play.num_envs > 1) pairs.insert({play.*first, play.*second});
  }
  return pairs;
}

TEST_CASE("The plays hold every pair of threads, chunk, batch size and order", "[bit_identity]") {
  CHECK(pairs_of(&Play::threads, &Play::chunk, false).size() == 5 * 3);
  CHECK(pairs_of(&Play::threads, &Play::num_envs, false).size() == 5 * 2);
  CHECK(pairs_of(&Play::threads, &Play::shuffled, false).size() == 5 * 2);
  CHECK(pairs_of(&Play::chunk, &Play::num_envs).size() == 3 * 3);
  CHECK(pairs_of(&Play::chunk, &Play::shuffled).size() == 3 * 2);
  CHECK(pairs_of(&Play::num_envs, &Play::shuffled).size() == 3 * 2);
}

// Checks a task of 20 steps that holds nothing but the robot, with something changed.
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

TEST_CASE("Nothing differs where nothing should", "[bit_identity]") {
  const IdentityResult result = check_unchanged();
  CHECK(result.different == 0);
  CHECK(result.plays == 18);
  // The batches of 7 are filled up with 5 stretches; 16 episodes are played to step 18.
  const auto sevens = std::count_if(plays().begin(), plays().end(),
                                    [](const Play& play) { return play.num_envs == 7; });
  CHECK(result.env_steps == 4 * (18 * 128 + 5 * sevens) + 16 * 18);
  CHECK(result.episodes >= 18 * 16);  // those that are followed past their end
  CHECK(check_unchanged().fingerprint == result.fingerprint);
  CHECK(check_unchanged(64).fingerprint != result.fingerprint);
}

TEST_CASE("A dependence on the slot is found", "[bit_identity]") {
  const IdentityResult result = check_changed(
      [](SceneTask& task) { task.reward = [](int env) { return env == 3 ? 1e-30F : 0.0F; }; });
  CHECK(result.different > 0);
  CHECK(result.fingerprint != check_unchanged().fingerprint);
}

TEST_CASE("A dependence on who came first is found", "[bit_identity]") {
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

// A task that remembers its slot, without showing it.
TEST_CASE("A dependence that is remembered only is found", "[bit_identity]") {
  const IdentityResult result = check_changed([](SceneTask& task) {
    task.on_reset = [&task](int env) {
      const ColumnView column = task.engine.memory->find("action");
      reinterpret_cast<float*>(column.row(env))[6] = env == 2 ? 1.0F : 0.0F;
    };
  });
  CHECK(result.different > 0);
  CHECK(result.fingerprint == check_unchanged().fingerprint);
}

TEST_CASE("Real tasks show the same bits in every play", "[bit_identity]") {
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
