// Numbers that are not finite, or absurd, written into an environment's memory at any time. They
// end that environment's episode and do not touch the others.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/batch/scripted_policy.h"
#include "core/math/random.h"
#include "tasks/family_samples.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::env_bytes, test::make_env;

constexpr double kValues[] = {std::numeric_limits<double>::quiet_NaN(),
                              std::numeric_limits<double>::infinity(),
                              -std::numeric_limits<double>::infinity(), 1e30, -1e200};
constexpr int kEnvs = 3;

// Which of the numbers that policies and learners see of an environment is not finite, or "".
std::string not_finite(const Batch& batch, int index) {
  for (const char* name : {"observation", "proprio", "reward"}) {
    const ColumnView column = batch.output(name);
    const auto* values = test::row<float>(column, index);
    const bool finite = std::all_of(values, values + column.field->width,
                                    [](float value) { return std::isfinite(value); });
    if (!finite) return name;
  }
  const bool finite = std::isfinite(*test::row<double>(batch.output("episode_return"), index));
  return finite ? "" : "episode_return";
}

// A real number of an environment's memory.
struct Place {
  ColumnView column;
  int index;

  void write(int env, double value) const {
    if (column.field->dtype == DType::kFloat64) {
      reinterpret_cast<double*>(column.row(env))[index] = value;
    } else {
      reinterpret_cast<float*>(column.row(env))[index] = static_cast<float>(value);
    }
  }
  bool absurd(int env) const {
    return !(std::abs(reinterpret_cast<const double*>(column.row(env))[index]) < 1e20);
  }
};

Place any_place(const Batch& batch, RandomStream& random, bool physical) {
  static const std::vector<std::string> columns = {"qpos", "qvel", "prop_pos", "prop_quat",
                                                   "prop_qvel"};
  while (true) {
    const auto last = static_cast<int>(test::memory_of(batch).size()) - 1;
    const ColumnView column =
        test::memory_of(batch)[static_cast<std::size_t>(random.integer(0, last))];
    const Field& field = *column.field;
    if (field.dtype != DType::kFloat64 && field.dtype != DType::kFloat32) continue;
    const bool named = std::find(columns.begin(), columns.end(), field.name) != columns.end();
    if (physical && !named) continue;
    return {column, random.integer(0, field.width - 1)};
  }
}

struct Trial {
  std::string id;
  AutoReset auto_reset = AutoReset::kNextStep;
  bool physical = false;  // a number that physics reads: it must notice at once
};

// Plays two batches side by side, one of which gets a fault.
void play(const Trial& trial, RandomStream& random, Batch& sound, Batch& batch) {
  const std::uint64_t seed[] = {static_cast<std::uint64_t>(random.integer(0, 1000)), 7, 8};
  sound.reset({.mask = {}, .seeds = seed, .pins = nullptr});
  batch.reset({.mask = {}, .seeds = seed, .pins = nullptr});
  const int steps = random.integer(0, 25);
  for (int i = 0; i < steps; ++i) {
    const std::vector<float> actions = test::act(sound, Policy::kOracle);
    sound.step(actions);
    batch.step(actions);
  }
  const int faulty = random.integer(0, kEnvs - 1);
  const std::uint64_t episode = batch.state().episode[faulty];
  // An environment that waits for its reset forgets everything anyway.
  if (batch.state().finished[faulty] != 0) return;
  const Place place = any_place(batch, random, trial.physical);
  const double value = kValues[random.integer(0, 4)];
  place.write(faulty, value);
  INFO(trial.id << ", step " << steps << ", " << place.column.field->name << "[" << place.index
                << "] = " << value << ", reset mode " << static_cast<int>(trial.auto_reset));
  bool flagged = false;
  bool was_reset = false;
  for (int i = 0; i < 8; ++i) {
    was_reset |= flagged && trial.auto_reset == AutoReset::kNextStep;
    const std::vector<float> actions = test::act(sound, Policy::kOracle);
    sound.step(actions);
    batch.step(actions);
    for (int other = 0; other < kEnvs; ++other) {
      if (other != faulty) REQUIRE((env_bytes(batch, other) == env_bytes(sound, other)));
    }
    REQUIRE((batch.outputs().unstable[faulty] == 0 || batch.outputs().truncated[faulty] != 0));
    if (batch.outputs().unstable[faulty] != 0) {
      REQUIRE_FALSE(flagged);  // once, and the next episode is sound
      flagged = true;
      was_reset = trial.auto_reset == AutoReset::kSameStep;
      REQUIRE(std::isfinite(batch.outputs().reward[faulty]));
      if (trial.auto_reset == AutoReset::kSameStep) REQUIRE(not_finite(batch, faulty) == "");
    } else {
      REQUIRE(not_finite(batch, faulty) == "");
    }
    // Unless the task has placed the prop anew before physics read it.
    if (i == 0 && trial.physical) REQUIRE((flagged || !place.absurd(faulty)));
    if (flagged && trial.auto_reset == AutoReset::kOff) break;
  }
  if (was_reset) CHECK(batch.state().episode[faulty] == episode + 1);
}

void run_trials(const std::string& id, int trials, bool physical) {
  RandomStream random(physical ? 5 : 6, 0, 0);
  for (const AutoReset mode : {AutoReset::kNextStep, AutoReset::kSameStep, AutoReset::kOff}) {
    BatchOptions options{.num_envs = kEnvs};
    options.threads = 1;  // so that a fault could spread by way of the workspace
    options.auto_reset = mode;
    options.reward_mode = RewardMode::kDense;
    const auto sound = make_env(id, options);
    const auto batch = make_env(id, options);
    for (int i = 0; i < trials; ++i) play({id, mode, physical}, random, *sound, *batch);
  }
}

TEST_CASE("What physics cannot compute with ends that episode at once and alone", "[fault]") {
  for (const std::string& id : one_of_each_family()) run_trials(id, 6, true);
}

TEST_CASE("No output stops being finite without a flag, whatever is in memory", "[fault]") {
  for (const std::string& id : one_of_each_family()) run_trials(id, 6, false);
}

TEST_CASE("Any fault at any time stays where it is", "[fault][long]") {
  for (const std::string& id : one_of_each_family()) {
    run_trials(id, 30, true);
    run_trials(id, 60, false);
  }
}

// Whatever finite numbers actions hold, in any mode.
TEST_CASE("Absurd actions end an episode at worst, in every control mode", "[fault]") {
  constexpr float kActions[] = {0, 0.3F, -1, 1, -7, 3e3F, -1e9F, 1e20F, -3e38F, 3.4e38F, 1e-40F};
  RandomStream random(9, 0, 0);
  for (int mode = 0; mode < kControlModes; ++mode) {
    BatchOptions options{
        .num_envs = 2, .control_mode = static_cast<ControlMode>(mode), .freeze_cue = false};
    const auto batch = make_env("RememberColor3-VLA-v0", options);
    options.num_envs = 1;
    const auto alone = make_env("RememberColor3-VLA-v0", options);
    batch->reset();
    alone->reset();
    std::vector<float> calm(static_cast<std::size_t>(batch->action_dim()));
    for (int step = 0; step < 60; ++step) {
      // The first environment moves sensibly and is never disturbed by the second.
      ScriptedPolicy(*alone, Policy::kRandom).act(calm);
      std::vector<float> actions = test::zeros(*batch);
      std::copy(calm.begin(), calm.end(), actions.begin());
      for (std::size_t i = calm.size(); i < actions.size(); ++i) {
        actions[i] = kActions[random.integer(0, 10)];
      }
      batch->step(actions);
      alone->step(calm);
      INFO(name_of(*options.control_mode) << ", step " << step);
      REQUIRE((env_bytes(*batch, 0) == env_bytes(*alone, 0)));
      REQUIRE((batch->outputs().unstable[1] == 0 || batch->outputs().truncated[1] != 0));
      if (batch->outputs().unstable[1] == 0) REQUIRE(not_finite(*batch, 1) == "");
    }
  }
}

}  // namespace
}  // namespace engram
