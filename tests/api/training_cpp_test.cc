// The C++ header of the preset for training as users see it.
#include <catch2/catch.hpp>
#include <utility>

#include "engram/engram_training.h"

namespace {

using engram::AutoReset, engram::Error, engram::TrainingEnv;

constexpr const char* kId = "RememberColor3-VLA-v0";

TEST_CASE("A loop of training runs through the C++ header", "[training_cpp]") {
  TrainingEnv made(kId, {.num_envs = 3, .threads = 1, .auto_reset = AutoReset::kSameStep},
                   {.gamma = 0.9, .smoothing = 0.2});
  TrainingEnv env = std::move(made);
  CHECK(env.observation_dim() != env.batch().state_dim());
  CHECK(env.action_high()[3] == Approx(10));
  CHECK(env.action_low()[3] == Approx(-10));
  const std::vector<float> actions(env.batch().make_actions().size(), 1.0F);
  env.reset();
  for (int i = 0; i < env.batch().horizon(); ++i) env.step(actions);
  const auto dim = static_cast<std::size_t>(env.observation_dim());
  CHECK(env.observation().size() == 3 * dim);
  CHECK(env.batch().final_mask()[1] == 1);
  CHECK(env.observation()[2 * dim - 1] == 1);
  CHECK(env.final_observation()[2 * dim - 1] == 0);
  CHECK(env.reward().size() == 3);
  CHECK(env.reward()[1] != env.batch().reward()[1]);
}

TEST_CASE("Several tasks and batches of one's own have the preset", "[training_cpp]") {
  TrainingEnv group(engram::make_group(
      {{.id = kId, .num_envs = 1}, {.id = "ShellGameTouch-VLA-v0", .num_envs = 2}},
      {.terminate_on_success = true}));
  group.reset();
  CHECK(group.reward().size() == 3);
  CHECK(group.final_observation().empty());
  TrainingEnv own(engram::make(kId, {.terminate_on_success = true}), {.time_left = false});
  const std::vector<std::uint64_t> seeds = {9};
  own.reset({.seeds = seeds});
  CHECK(own.observation_dim() + 1 == TrainingEnv(kId).observation_dim());
}

TEST_CASE("The preset refuses batches whose episodes go on", "[training_cpp]") {
  const auto check_refused = [](auto&& f, Error::Kind kind) {
    try {
      f();
      FAIL_CHECK("nothing was thrown");
    } catch (const Error& error) {
      CHECK(error.kind() == kind);
    }
  };
  const auto invalid = Error::Kind::kInvalidArgument;
  check_refused([] { TrainingEnv(kId, {.terminate_on_success = false}); }, invalid);
  check_refused([] { TrainingEnv(kId, {}, {.gamma = 2}); }, invalid);
  TrainingEnv env(kId);
  check_refused([&] { env.step(std::vector<float>(7)); }, Error::Kind::kBadState);
  const std::vector<std::uint8_t> mask(2, 1);
  check_refused([&] { env.reset({.mask = mask}); }, invalid);
}

}  // namespace
