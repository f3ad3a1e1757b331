#include "apps/digest.h"

#include <catch2/catch.hpp>

#include "core/batch/scripted_policy.h"

namespace engram::apps {
namespace {

std::uint64_t digest_of(std::uint64_t seed, int threads, ObsMode obs_mode, int steps) {
  MakeOptions options;
  options.num_envs = 3;
  options.threads = threads;
  options.seed = seed;
  options.obs_mode = obs_mode;
  const auto batch = make("RememberColor3-VLA-v0", options);
  batch->reset();
  Digest digest(3);
  digest.update(*batch);
  std::vector<float> actions(static_cast<std::size_t>(3 * batch->action_dim()));
  for (int i = 0; i < steps; ++i) {
    ScriptedPolicy(*batch, Policy::kRandom).act(actions);
    batch->step(actions);
    digest.update(*batch);
  }
  return digest.value();
}

TEST_CASE("A digest depends on seed, steps and observation, not on threads", "[apps]") {
  const std::uint64_t digest = digest_of(1, 1, ObsMode::kState, 3);
  CHECK(digest_of(1, 2, ObsMode::kState, 3) == digest);
  CHECK(digest_of(2, 1, ObsMode::kState, 3) != digest);
  CHECK(digest_of(1, 1, ObsMode::kState, 2) != digest);
  CHECK(digest_of(1, 1, ObsMode::kRgb, 3) != digest);
}

}  // namespace
}  // namespace engram::apps
