#include "protocol/training/preset.h"

#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/batch/scripted_policy.h"
#include "protocol/make/make.h"

namespace engram::training {
namespace {

constexpr int kNumEnvs = 4;

std::unique_ptr<Batch> make_batch(int threads, const char* id = "ShellGameTouch-VLA-v0") {
  MakeOptions options;
  options.num_envs = kNumEnvs;
  options.threads = threads;
  options.terminate_on_success = true;
  options.auto_reset = AutoReset::kOff;
  return make(id, options);
}

// Rewards of an episode of the oracle or, standing still, of no policy: (steps, num_envs).
std::vector<std::array<float, kNumEnvs>> play(Batch& batch, const Options& options, Policy policy,
                                              int steps) {
  Preset preset(batch, options);
  preset.reset();
  std::vector<float> actions(kNumEnvs * at(batch.action_dim()));
  std::vector<std::array<float, kNumEnvs>> rewards;
  for (int i = 0; i < steps; ++i) {
    ScriptedPolicy(batch, policy).act(actions);
    preset.step(actions);
    std::ranges::copy(preset.reward(), rewards.emplace_back().begin());
  }
  return rewards;
}

TEST_CASE("What a potential has paid is lost by going back", "[training]") {
  const std::unique_ptr<Batch> batch = make_batch(1);
  const Options options = {.gamma = 1, .scale_actions = false, .bonus = 0};
  const auto rewards = play(*batch, options, Policy::kOracle, 40);
  for (std::size_t env = 0; env < kNumEnvs; ++env) {
    double sum = 0;
    for (const auto& step : rewards) sum += static_cast<double>(step[env]);
    CHECK(sum > 1);    // success has a dense reward of 1, and the hand is near
    CHECK(sum < 2.1);  // one distance of weight 1 besides
  }
}

TEST_CASE("Success pays the discounted rest of the horizon", "[training]") {
  const std::unique_ptr<Batch> batch = make_batch(1);
  const Options options = {.gamma = 0.9, .scale_actions = false, .potential = 0, .bonus = 2};
  const auto rewards = play(*batch, options, Policy::kOracle, 40);
  const std::span<const std::int32_t> elapsed(
      reinterpret_cast<const std::int32_t*>(batch->output("elapsed_steps").data), kNumEnvs);
  for (std::size_t env = 0; env < kNumEnvs; ++env) {
    REQUIRE(elapsed[env] < batch->horizon());
    const double left = batch->horizon() - elapsed[env] + 1;
    const double bonus = 2 * (1 - std::pow(0.9, left)) / (1 - 0.9);
    CHECK(static_cast<double>(rewards[at(elapsed[env] - 1)][env]) == Approx(bonus + 1));
    CHECK(rewards[at(elapsed[env])][env] == 0);
  }
}

TEST_CASE("Threads change nothing", "[training]") {
  const std::unique_ptr<Batch> one = make_batch(1);
  const std::unique_ptr<Batch> three = make_batch(3);
  const Options options = {.smoothing = 0.2, .still = 1};
  CHECK(play(*one, options, Policy::kOracle, 40) == play(*three, options, Policy::kOracle, 40));
}

}  // namespace
}  // namespace engram::training
