// What steps and resets promise (docs/evaluation.md), seen from a task and from the outputs.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/batch/snapshot.h"
#include "tests/core/batch/scene_task.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::row, test::SceneTask, test::step, test::zeros;

struct Logged {
  explicit Logged(BatchOptions options = {}, int horizon = 1000) {
    auto owned = std::make_unique<SceneTask>();
    task = owned.get();
    task->description.horizon = horizon;
    task->on_reset = [this](int index) { note("reset", index); };
    task->on_before_physics = [this](int index) { note("before", index); };
    task->on_advance = [this](int index) { note("advance", index); };
    task->on_evaluate = [this](int index) { note("evaluate", index); };
    task->on_observe = [this](int index) { note("observe", index); };
    task->reward = [this](int index) {
      note("reward", index);
      return 2.0F;
    };
    options.threads = 1;
    batch = std::make_unique<Batch>(std::move(owned), options);
  }
  void note(const char* call, int index) {
    log.push_back(std::string(call) + "@" + std::to_string(task->engine.state->elapsed[index]));
  }

  std::vector<std::string> log;
  SceneTask* task = nullptr;
  std::unique_ptr<Batch> batch;
};

TEST_CASE("A reset samples, evaluates once at elapsed 0 and observes", "[batch]") {
  Logged logged;
  CHECK(logged.log.empty());
  logged.batch->reset();
  CHECK(logged.log == std::vector<std::string>{"reset@0", "advance@0", "evaluate@0", "observe@0"});
  CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == 0);
  CHECK(logged.batch->outputs().reward[0] == 0);
}

TEST_CASE("A step counts after physics and before evaluation", "[batch]") {
  Logged logged;
  logged.batch->reset();
  logged.log.clear();
  step(*logged.batch, Policy::kZero);
  CHECK(logged.log ==
        std::vector<std::string>{"before@0", "advance@1", "evaluate@1", "observe@1", "reward@1"});
  CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == 1);
  logged.log.clear();
  step(*logged.batch, Policy::kZero);
  CHECK(logged.log.front() == "before@1");
  CHECK(logged.log.back() == "reward@2");
}

TEST_CASE("Truncation comes exactly at the horizon", "[batch]") {
  Logged logged({}, 5);
  logged.batch->reset();
  for (int i = 1; i <= 5; ++i) {
    step(*logged.batch, Policy::kZero);
    CHECK(logged.batch->outputs().truncated[0] == (i == 5 ? 1 : 0));
    CHECK(logged.batch->outputs().terminated[0] == 0);
  }
}

TEST_CASE("With next step resets the step after an end ignores its action", "[batch]") {
  Logged logged({}, 2);
  logged.batch->reset();
  const std::vector<float> first(logged.batch->outputs().observation.begin(),
                                 logged.batch->outputs().observation.end());
  step(*logged.batch, Policy::kZero);
  step(*logged.batch, Policy::kZero);
  CHECK(logged.batch->outputs().truncated[0] == 1);
  CHECK(logged.batch->outputs().observation.back() == 2);
  CHECK(*row<double>(logged.batch->output("episode_return"), 0) == 4);
  logged.log.clear();
  const std::vector<float> push(7, 1.0F);
  logged.batch->step(push);
  CHECK(logged.log == std::vector<std::string>{"reset@0", "advance@0", "evaluate@0", "observe@0"});
  CHECK(logged.batch->outputs().truncated[0] == 0);
  CHECK(logged.batch->outputs().reward[0] == 0);
  CHECK(logged.batch->outputs().observation.back() == 0);
  CHECK(logged.batch->outputs().observation[0] != first[0]);  // an episode of its own
  CHECK(logged.batch->outputs().observation[9] == 0);         // at rest
  CHECK(*row<double>(logged.batch->output("episode_return"), 0) == 0);
  CHECK(logged.batch->state().episode[0] == 1);
}

TEST_CASE("With same step resets the last observation is kept as final", "[batch]") {
  const BatchOptions options{.auto_reset = AutoReset::kSameStep};
  Logged logged(options, 2);
  logged.batch->reset();
  step(*logged.batch, Policy::kZero);
  CHECK(logged.batch->outputs().final_mask[0] == 0);
  step(*logged.batch, Policy::kZero);
  CHECK(logged.batch->outputs().final_mask[0] == 1);
  CHECK(logged.batch->outputs().truncated[0] == 1);
  CHECK(logged.batch->outputs().reward[0] == 2);
  CHECK(logged.batch->outputs().observation.back() == 0);
  CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == 0);
  const auto* final_row = row<float>(logged.batch->final_output("observation"), 0);
  CHECK(final_row[logged.batch->state_dim() - 1] == 2);
  CHECK(*row<std::int32_t>(logged.batch->final_output("elapsed_steps"), 0) == 2);
  CHECK(*row<double>(logged.batch->final_output("episode_return"), 0) == 4);
  step(*logged.batch, Policy::kZero);
  CHECK(logged.batch->outputs().final_mask[0] == 0);
  CHECK(logged.batch->outputs().truncated[0] == 0);
  CHECK(logged.batch->outputs().observation.back() == 1);
}

TEST_CASE("Without resets an environment that has ended is left alone", "[batch]") {
  const BatchOptions options{.auto_reset = AutoReset::kOff};
  Logged logged(options, 2);
  logged.batch->reset();
  step(*logged.batch, Policy::kZero);
  step(*logged.batch, Policy::kZero);
  CHECK(logged.batch->outputs().reward[0] == 2);
  const std::vector<float> last(logged.batch->outputs().observation.begin(),
                                logged.batch->outputs().observation.end());
  const std::vector<float> push(7, 1.0F);
  for (int i = 0; i < 3; ++i) {
    logged.log.clear();
    logged.batch->step(push);
    CHECK(logged.log.empty());
    CHECK(logged.batch->outputs().reward[0] == 0);
    CHECK(logged.batch->outputs().truncated[0] == 1);
    CHECK(std::equal(last.begin(), last.end(), logged.batch->outputs().observation.begin()));
  }
  logged.batch->reset();
  CHECK(logged.batch->outputs().truncated[0] == 0);
  CHECK(logged.batch->outputs().observation.back() == 0);
}

BatchOptions going_on() {
  BatchOptions options{.auto_reset = AutoReset::kOff, .after_end = AfterEnd::kContinue};
  return options;
}

TEST_CASE("An environment that has ended can be simulated on", "[batch]") {
  Logged logged(going_on(), 2);
  SceneTask* task = logged.task;
  task->description.termination = Termination::kSuccess;
  task->on_evaluate = [task](int env) {
    task->engine.success[env] = task->engine.state->elapsed[env] == 4 ? 1 : 0;
  };
  logged.batch->reset();
  for (int i = 1; i <= 6; ++i) {
    logged.log.clear();
    step(*logged.batch, Policy::kOracle);
    CHECK(logged.log.size() == 4);
    CHECK(logged.batch->outputs().reward[0] == 2);
    CHECK(logged.batch->outputs().success[0] == (i == 4 ? 1 : 0));
    CHECK(logged.batch->outputs().terminated[0] == (i == 4 ? 1 : 0));
    CHECK(logged.batch->outputs().truncated[0] == (i >= 2 ? 1 : 0));
    CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == i);
    CHECK(*row<double>(logged.batch->output("episode_return"), 0) == 2 * i);
    CHECK(logged.batch->outputs().observation.back() == static_cast<float>(i));
  }
  // A snapshot of it goes on where the same is asked for.
  const std::vector<std::byte> saved = Snapshotter(*logged.batch).save();
  step(*logged.batch, Policy::kOracle);
  Snapshotter(*logged.batch).restore(saved);
  CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == 6);
  step(*logged.batch, Policy::kOracle);
  CHECK(*row<std::int32_t>(logged.batch->output("elapsed_steps"), 0) == 7);
  logged.batch->reset();
  CHECK(logged.batch->outputs().truncated[0] == 0);
}

TEST_CASE("Steps after an end can be refused", "[batch]") {
  BatchOptions options{.auto_reset = AutoReset::kOff, .after_end = AfterEnd::kRefuse};
  Logged logged(options, 1);
  logged.batch->reset();
  step(*logged.batch, Policy::kZero);
  logged.log.clear();
  CHECK_THROWS_WITH(step(*logged.batch, Policy::kZero),
                    Catch::Matchers::Contains("environment 0 has ended; reset it"));
  CHECK(logged.log.empty());
  logged.batch->reset();
  CHECK_NOTHROW(step(*logged.batch, Policy::kZero));
  // What is to go on cannot be reset by itself.
  options = going_on();
  options.auto_reset = AutoReset::kNextStep;
  CHECK_THROWS_WITH(Logged(options), Catch::Matchers::Contains("next-step given, off needed"));
}

// Success from the third step on, failure in the second.
std::unique_ptr<Logged> with_success(Termination rule, const BatchOptions& options,
                                     bool fails = false) {
  auto logged = std::make_unique<Logged>(options);
  SceneTask* task = logged->task;
  task->description.termination = rule;
  task->on_evaluate = [task, fails](int env) {
    const int elapsed = task->engine.state->elapsed[env];
    task->engine.success[env] = elapsed >= 3 ? 1 : 0;
    task->engine.failed[env] = fails && elapsed == 2 ? 1 : 0;
  };
  return logged;
}

int steps_to_termination(Batch& batch) {
  batch.reset();
  for (int i = 1; i <= 6; ++i) {
    step(batch, Policy::kZero);
    if (batch.outputs().terminated[0] != 0) return i;
  }
  return 0;
}

TEST_CASE("Termination follows the family unless the option overrides it", "[batch]") {
  const auto steps = [](Termination rule, std::optional<bool> override, bool fails = false) {
    const BatchOptions options{.terminate_on_success = override};
    return steps_to_termination(*with_success(rule, options, fails)->batch);
  };
  CHECK(steps(Termination::kNever, {}) == 0);
  CHECK(steps(Termination::kSuccess, {}) == 3);
  CHECK(steps(Termination::kSuccess, {}, true) == 3);
  CHECK(steps(Termination::kSuccessOrFailed, {}) == 3);
  CHECK(steps(Termination::kSuccessOrFailed, {}, true) == 2);
  CHECK(steps(Termination::kNever, true) == 3);
  CHECK(steps(Termination::kSuccess, false) == 0);
  CHECK(steps(Termination::kSuccessOrFailed, false, true) == 2);
  const auto steps_on = [](std::optional<bool> override) {
    const BatchOptions options{.terminate_on_success = override, .terminate_on_failure = false};
    return steps_to_termination(*with_success(Termination::kSuccessOrFailed, options, true)->batch);
  };
  CHECK(steps_on({}) == 3);
  CHECK(steps_on(false) == 0);
}

TEST_CASE("Success is latched for the episode only", "[batch]") {
  Logged logged;
  SceneTask* task = logged.task;
  task->on_evaluate = [task](int env) {
    task->engine.success[env] = task->engine.state->elapsed[env] == 2 ? 1 : 0;
  };
  logged.batch->reset();
  const auto once = [&] {
    return int{*row<std::uint8_t>(logged.batch->output("success_once"), 0)};
  };
  for (int i = 1; i <= 4; ++i) {
    step(*logged.batch, Policy::kZero);
    CHECK(logged.batch->outputs().success[0] == (i == 2 ? 1 : 0));
    CHECK(once() == (i >= 2 ? 1 : 0));
  }
  logged.batch->reset();
  CHECK(once() == 0);
}

TEST_CASE("Success at reset counts for nothing", "[batch]") {
  Logged logged;
  SceneTask* task = logged.task;
  task->on_evaluate = [task](int env) {
    task->engine.success[env] = task->engine.state->elapsed[env] == 0 ? 1 : 0;
  };
  logged.batch->reset();
  CHECK(*row<std::uint8_t>(logged.batch->output("success_once"), 0) == 0);
  step(*logged.batch, Policy::kZero);
  CHECK(*row<std::uint8_t>(logged.batch->output("success_once"), 0) == 0);
}

TEST_CASE("Rewards are those of the mode", "[batch]") {
  const auto reward = [](RewardMode mode) {
    const BatchOptions options{.reward_mode = mode};
    auto owned = std::make_unique<SceneTask>();
    SceneTask* task = owned.get();
    task->description.success_reward = 4;
    task->reward = [](int) { return 3.0F; };
    task->on_evaluate = [task](int env) {
      task->engine.success[env] = task->engine.state->elapsed[env] == 2 ? 1 : 0;
    };
    Batch batch(std::move(owned), options);
    batch.reset();
    std::array<float, 2> rewards{};
    for (float& value : rewards) {
      step(batch, Policy::kZero);
      value = batch.outputs().reward[0];
    }
    return rewards;
  };
  CHECK(reward(RewardMode::kNone) == std::array{0.0F, 0.0F});
  CHECK(reward(RewardMode::kSparse) == std::array{0.0F, 1.0F});
  CHECK(reward(RewardMode::kDense) == std::array{3.0F, 3.0F});
  CHECK(reward(RewardMode::kNormalizedDense) == std::array{0.75F, 0.75F});
}

TEST_CASE("A task sees the action of the step and the one before", "[batch]") {
  Logged logged;
  logged.batch->reset();
  const Bindings& engine = logged.task->engine;
  CHECK(engine.action.row(0)[0] == 0);
  logged.batch->step(std::vector<float>(7, 0.25F));
  CHECK(engine.action.row(0)[6] == 0.25F);
  CHECK(engine.previous_action.row(0)[6] == 0);
  logged.batch->step(std::vector<float>(7, 0.5F));
  CHECK(engine.action.row(0)[6] == 0.5F);
  CHECK(engine.previous_action.row(0)[6] == 0.25F);
}

TEST_CASE("Actions are frozen until the cue is over unless the option says otherwise", "[batch]") {
  const auto arm_moved_at = [](ControlMode mode, bool freeze) {
    const BatchOptions options{.control_mode = mode, .freeze_cue = freeze};
    auto logged = std::make_unique<Logged>(options);
    SceneTask* task = logged->task;
    task->on_reset = [task](int env) { task->engine.freeze_steps[env] = 4; };
    Batch& batch = *logged->batch;
    batch.reset();
    std::vector<float> push = test::act(batch, Policy::kRandom);
    for (int i = 1; i <= 8; ++i) {
      const double before = batch.state().qpos.row(0)[5];
      batch.step(push);
      if (std::abs(batch.state().qpos.row(0)[5] - before) > 1e-4) return i;
    }
    return 0;
  };
  // Four frozen steps: the first live action is the one taken at elapsed 4.
  CHECK(arm_moved_at(ControlMode::kPdEeDeltaPose, true) == 5);
  CHECK(arm_moved_at(ControlMode::kPdEeDeltaPose, false) == 1);
  CHECK(arm_moved_at(ControlMode::kPdJointPos, true) == 5);
  CHECK(arm_moved_at(ControlMode::kPdJointPos, false) == 1);
}

TEST_CASE("A frozen action is zero in normalised modes and holds in joint positions", "[batch]") {
  BatchOptions options;
  options.robot_init_qpos_noise = 0;
  options.control_mode = GENERATE(ControlMode::kPdEeDeltaPose, ControlMode::kPdJointPos);
  Logged logged(options);
  SceneTask* task = logged.task;
  task->on_reset = [task](int env) { task->engine.freeze_steps[env] = 10; };
  logged.batch->reset();
  step(*logged.batch, Policy::kRandom);
  const float* action = task->engine.action.row(0);
  if (options.control_mode == ControlMode::kPdEeDeltaPose) {
    CHECK(std::all_of(action, action + 7, [](float v) { return v == 0; }));
    for (int i = 0; i < 2; ++i) step(*logged.batch, Policy::kRandom);
    CHECK(logged.batch->state().qpos.row(0)[7] == Approx(0.02).margin(0.003));
  } else {
    CHECK(action[3] == Approx(-2 * std::numbers::pi / 3));
    CHECK(action[7] == 1);  // 0.04 m open
    CHECK(logged.batch->state().qpos.row(0)[7] == Approx(0.04).margin(1e-6));
  }
}

}  // namespace
}  // namespace engram
