// The preset for training through the C API: its calls, ends of episodes and bounds. Python's tests
// compare its numbers with those of the wrappers.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "engram/engram_training_c.h"
#include "tests/allocation_counter.h"
#include "tests/api/c_api_fixture.h"

namespace engram::test {
namespace {

struct CloseTraining {
  void operator()(engram_training* training) const { engram_training_close(training); }
};
using TrainingHandle = std::unique_ptr<engram_training, CloseTraining>;

engram_options ending_options(engram_auto_reset mode = ENGRAM_AUTO_RESET_SAME_STEP) {
  engram_options options = default_options();
  options.terminate_on_success = 1;
  options.auto_reset = mode;
  return options;
}

engram_training_options training_options() {
  engram_training_options options;
  engram_training_options_init(&options);
  return options;
}

TrainingHandle make_training(const BatchHandle& batch,
                             const engram_training_options& options = training_options()) {
  engram_training* training = nullptr;
  const engram_status status = engram_training_make(batch.get(), &options, &training);
  INFO(engram_last_error());
  REQUIRE(status == ENGRAM_OK);
  return TrainingHandle(training);
}

// Actions of the oracle, as the preset takes them.
std::vector<float> scaled_oracle(const BatchHandle& batch, const TrainingHandle& training) {
  std::vector<float> actions = actions_of(batch, ENGRAM_POLICY_ORACLE);
  const float* const high = engram_training_action_high(training.get());
  for (std::size_t i = 0; i < actions.size(); ++i) actions[i] *= high[i % 7];
  return actions;
}

engram_status step(const TrainingHandle& training, const std::vector<float>& actions) {
  return engram_training_step(training.get(), actions.data(), actions.size());
}

std::vector<float> copy_of(const float* values, std::size_t count) {
  return {values, values + count};
}

std::vector<float> observation_of(const TrainingHandle& training) {
  return copy_of(engram_training_observation(training.get()),
                 4 * static_cast<std::size_t>(engram_training_observation_dim(training.get())));
}

// The last column of an environment's row.
float time_left(const float* rows, const TrainingHandle& training, int env) {
  const int dim = engram_training_observation_dim(training.get());
  return rows[(env + 1) * dim - 1];
}

TEST_CASE("Actions of the preset range beyond 1", "[training_c]") {
  const BatchHandle batch = make_batch(ending_options());
  const TrainingHandle training = make_training(batch);
  const float* const high = engram_training_action_high(training.get());
  const float* const low = engram_training_action_low(training.get());
  CHECK(high[0] == Approx(1 / 0.3));
  CHECK(high[5] == Approx(10));
  CHECK(high[6] == Approx(2));
  CHECK(low[6] == Approx(-2));
  engram_training_options plain = training_options();
  plain.scale_actions = 0;
  CHECK(engram_training_action_high(make_training(batch, plain).get())[0] == 1);
}

TEST_CASE("Success pays in the preset, and episodes begin anew", "[training_c]") {
  const BatchHandle batch = make_batch(ending_options());
  const TrainingHandle training = make_training(batch);
  REQUIRE(engram_training_reset(training.get(), nullptr) == ENGRAM_OK);
  const float* const reward = engram_training_reward(training.get());
  const auto* const mask = values<std::uint8_t>(output(batch, "final_mask"));
  engram_array once{};
  REQUIRE(engram_final_output(batch.get(), "success_once", &once) == ENGRAM_OK);
  int successes = 0;
  for (int i = 0; i < 50; ++i) {
    REQUIRE(step(training, scaled_oracle(batch, training)) == ENGRAM_OK);
    for (int env = 0; env < 4; ++env) {
      const bool success = mask[env] != 0 && values<std::uint8_t>(once)[env] != 0;
      successes += success ? 1 : 0;
      CHECK((reward[env] > 0.5F) == success);
      if (mask[env] == 0) continue;
      CHECK(time_left(engram_training_observation(training.get()), training, env) == 1);
      CHECK(time_left(engram_training_final_observation(training.get()), training, env) < 1);
    }
  }
  CHECK(successes >= 4);
}

TEST_CASE("Environments that wait for a reset pay nothing", "[training_c]") {
  const BatchHandle batch = make_batch(ending_options(ENGRAM_AUTO_RESET_OFF));
  const TrainingHandle training = make_training(batch);
  CHECK(engram_training_final_observation(training.get()) == nullptr);
  REQUIRE(engram_training_reset(training.get(), nullptr) == ENGRAM_OK);
  const std::vector<float> actions(action_count(batch), 0.0F);
  for (int i = 0; i < 26; ++i) REQUIRE(step(training, actions) == ENGRAM_OK);
  const float* const reward = engram_training_reward(training.get());
  const std::vector<float> held = observation_of(training);
  CHECK(std::count(reward, reward + 4, 0.0F) == 4);
  CHECK(time_left(held.data(), training, 2) == 0);

  const std::uint8_t mask[] = {0, 0, 1, 0};
  engram_reset_request request{};
  request.mask = mask;
  REQUIRE(engram_training_reset(training.get(), &request) == ENGRAM_OK);
  REQUIRE(step(training, actions) == ENGRAM_OK);
  const std::vector<float> rows = observation_of(training);
  CHECK(time_left(rows.data(), training, 2) == Approx(24.0 / 25));
  CHECK(time_left(rows.data(), training, 1) == 0);
  CHECK(reward[1] == 0);
  CHECK(reward[2] != 0);
}

TEST_CASE("An episode's rewards do not depend on the one before", "[training_c]") {
  const BatchHandle batch = make_batch(ending_options());
  engram_training_options options = training_options();
  options.smoothing = 0.5;
  const TrainingHandle training = make_training(batch, options);
  const std::uint64_t seeds[] = {5, 6, 7, 8};
  engram_reset_request request{};
  request.seeds = seeds;
  std::vector<std::vector<float>> first;
  for (const int steps : {7, 7}) {
    REQUIRE(engram_training_reset(training.get(), &request) == ENGRAM_OK);
    for (int i = 0; i < steps; ++i) {
      REQUIRE(step(training, std::vector<float>(28, 1.0F)) == ENGRAM_OK);
    }
    first.push_back(observation_of(training));
    first.push_back(copy_of(engram_training_reward(training.get()), 4));
  }
  CHECK(first[0] == first[2]);
  CHECK(first[1] == first[3]);
}

TEST_CASE("Batches without rows have the preset's reward", "[training_c]") {
  engram_options options = ending_options();
  options.obs_mode = ENGRAM_OBS_NONE;
  const BatchHandle batch = make_batch(options);
  const TrainingHandle training = make_training(batch);
  REQUIRE(engram_training_reset(training.get(), nullptr) == ENGRAM_OK);
  REQUIRE(step(training, std::vector<float>(28, 1.0F)) == ENGRAM_OK);
  CHECK(engram_training_observation_dim(training.get()) == 0);
  CHECK(engram_training_observation(training.get()) == nullptr);
  CHECK(engram_training_reward(training.get())[0] != 0);
}

TEST_CASE("Steps of the preset allocate nothing", "[training_c]") {
  for (const engram_obs_mode mode : {ENGRAM_OBS_STATE, ENGRAM_OBS_OBJECTS}) {
    engram_options options = ending_options();
    options.threads = 1;
    options.obs_mode = mode;
    const BatchHandle batch = make_batch(options);
    const TrainingHandle training = make_training(batch);
    REQUIRE(engram_training_reset(training.get(), nullptr) == ENGRAM_OK);
    const std::vector<float> actions(action_count(batch), 1.0F);
    REQUIRE(step(training, actions) == ENGRAM_OK);
    const std::int64_t before = allocation_count();
    for (int i = 0; i < 60; ++i) step(training, actions);
    CHECK(allocation_count() == before);
  }
}

TEST_CASE("Calls of the preset that are refused change nothing", "[training_c]") {
  const BatchHandle batch = make_running(ending_options());
  const TrainingHandle training = make_training(batch);
  const std::vector<float> actions(action_count(batch), 0.5F);
  check_refused(step(training, actions), ENGRAM_BAD_STATE, "before the first reset");
  const std::uint8_t mask[] = {1, 0, 1, 1};
  engram_reset_request request{};
  request.mask = mask;
  check_refused(engram_training_reset(training.get(), &request), ENGRAM_BAD_STATE,
                "environment 1 masked out");
  REQUIRE(engram_training_reset(training.get(), nullptr) == ENGRAM_OK);
  REQUIRE(step(training, actions) == ENGRAM_OK);
  const std::vector<float> before = observation_of(training);
  const std::vector<std::byte> outputs = outputs_of(batch);

  check_refused(engram_training_step(training.get(), actions.data(), 27), ENGRAM_INVALID_ARGUMENT,
                "actions: 27");
  check_refused(engram_training_step(training.get(), nullptr, 28), ENGRAM_INVALID_ARGUMENT,
                "actions: NULL");
  std::vector<float> infinite = actions;
  infinite[3] = std::numeric_limits<float>::infinity();
  CHECK(step(training, infinite) == ENGRAM_INVALID_ARGUMENT);
  check_refused(engram_training_step(nullptr, actions.data(), 28), ENGRAM_INVALID_ARGUMENT,
                "training: NULL");
  check_refused(engram_training_reset(nullptr, nullptr), ENGRAM_INVALID_ARGUMENT, "training: NULL");
  CHECK(engram_training_reward(nullptr) == nullptr);
  CHECK(engram_training_observation_dim(nullptr) == 0);
  CHECK(observation_of(training) == before);
  CHECK(outputs_of(batch) == outputs);
}

TEST_CASE("A preset that cannot be made is refused", "[training_c]") {
  engram_options endless = ending_options();
  endless.terminate_on_success = -1;
  const BatchHandle batch = make_batch(ending_options());
  engram_training* training = nullptr;
  check_refused(engram_training_make(make_batch(endless).get(), nullptr, &training),
                ENGRAM_INVALID_ARGUMENT, "terminate_on_success: off given for RememberColor3");
  check_refused(engram_training_make(nullptr, nullptr, &training), ENGRAM_INVALID_ARGUMENT,
                "env: NULL");
  check_refused(engram_training_make(batch.get(), nullptr, nullptr), ENGRAM_INVALID_ARGUMENT,
                "training: NULL");
  const auto check_option = [&](double engram_training_options::*option, double value,
                                const char* message) {
    engram_training_options options = training_options();
    options.*option = value;
    check_refused(engram_training_make(batch.get(), &options, &training), ENGRAM_INVALID_ARGUMENT,
                  message);
    CHECK(training == nullptr);
  };
  check_option(&engram_training_options::gamma, 0, "gamma: 0 given, more than 0, up to 1 needed");
  check_option(&engram_training_options::smoothing, 1, "smoothing: 1 given");
  check_option(&engram_training_options::potential, -1, "potential: -1 given");
  check_option(&engram_training_options::still, std::nan(""), "still: nan given");
  check_option(&engram_training_options::bonus, -0.5, "bonus: -0.5 given, 0 to 1e6 needed");
  engram_training_options options = training_options();
  options.time_left = 2;
  check_refused(engram_training_make(batch.get(), &options, &training), ENGRAM_INVALID_ARGUMENT,
                "time_left: 2 given");
  options = {};
  check_refused(engram_training_make(batch.get(), &options, &training), ENGRAM_INVALID_ARGUMENT,
                "struct_size");
}

}  // namespace
}  // namespace engram::test
