#include "apps/episode_log.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "core/batch/scripted_policy.h"

namespace engram::apps {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

std::unique_ptr<Batch> batch_of(int num_envs, AutoReset mode) {
  MakeOptions options;
  options.num_envs = num_envs;
  options.threads = 1;
  options.auto_reset = mode;
  auto batch = make(kId, options);
  batch->reset();
  return batch;
}

void step(Batch& batch, EpisodeLog& log) {
  std::vector<float> actions(static_cast<std::size_t>(batch.num_envs() * batch.action_dim()));
  ScriptedPolicy(batch, Policy::kOracle).act(actions);
  batch.step(actions);
  log.update(batch);
}

TEST_CASE("Environments share the episodes that are counted", "[apps]") {
  for (const AutoReset mode : {AutoReset::kNextStep, AutoReset::kSameStep}) {
    const auto batch = batch_of(2, mode);
    EpisodeLog log(*batch, 3);
    CHECK(std::isnan(log.success_rate()));
    for (int i = 0; i < 1000 && !log.complete(); ++i) step(*batch, log);
    CHECK(log.complete());
    CHECK(log.episodes() == 3);
    CHECK(log.fraction() == 1);
    CHECK(log.success_rate() > 0.5);
    CHECK(log.mean_return() > 0);
  }
}

TEST_CASE("Steps of ended environments are not counted", "[apps]") {
  const auto batch = batch_of(1, AutoReset::kOff);
  EpisodeLog log(*batch, 0);
  CHECK(log.fraction() == 0);
  for (int i = 0; i < 1000 && !log.complete(); ++i) step(*batch, log);
  CHECK(log.complete());
  CHECK(log.episodes() == 1);
  const std::int64_t steps = log.env_steps();
  CHECK(steps == batch->state().elapsed[0]);
  step(*batch, log);
  CHECK(log.env_steps() == steps);
}

}  // namespace
}  // namespace engram::apps
