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
  auto env = make(kId, options);
  env->reset();
  return env;
}

void step(Batch& env, EpisodeLog& log) {
  std::vector<float> actions(static_cast<std::size_t>(env.num_envs() * env.action_dim()));
  ScriptedPolicy(env, Policy::kOracle).act(actions);
  env.step(actions);
  log.update(env);
}

TEST_CASE("Environments share the episodes that are counted", "[apps]") {
  for (const AutoReset mode : {AutoReset::kNextStep, AutoReset::kSameStep}) {
    const auto env = batch_of(2, mode);
    EpisodeLog log(*env, 3);
    CHECK(std::isnan(log.success_rate()));
    for (int i = 0; i < 1000 && !log.complete(); ++i) step(*env, log);
    CHECK(log.complete());
    CHECK(log.episodes() == 3);
    CHECK(log.fraction() == 1);
    CHECK(log.success_rate() > 0.5);
    CHECK(log.mean_return() > 0);
  }
}

TEST_CASE("Steps of ended environments are not counted", "[apps]") {
  const auto env = batch_of(1, AutoReset::kOff);
  EpisodeLog log(*env, 0);
  CHECK(log.fraction() == 0);
  for (int i = 0; i < 1000 && !log.complete(); ++i) step(*env, log);
  CHECK(log.complete());
  CHECK(log.episodes() == 1);
  const std::int64_t steps = log.env_steps();
  CHECK(steps == env->state().elapsed[0]);
  step(*env, log);
  CHECK(log.env_steps() == steps);
}

}  // namespace
}  // namespace engram::apps
