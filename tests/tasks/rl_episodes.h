// Episodes of RL tasks, for tests of their families: played by several policies in turn, and looked
// at in every step.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tests/env_helpers.h"

namespace engram::test {

// The names of fields, in order.
inline std::vector<std::string> names_of(const std::vector<Field>& fields) {
  std::vector<std::string> names;
  for (const Field& field : fields) names.push_back(field.name);
  return names;
}

// Facts that hold for all RL tasks.
inline void check_rl_facts(const std::string& id, int horizon, const char* memory_type) {
  INFO(id);
  const auto batch = make_env(id);
  const TaskInfo& info = batch->info();
  CHECK(info.horizon == horizon);
  CHECK(info.memory_type == memory_type);
  CHECK(info.split == "rl");
  CHECK_FALSE(info.canonical);
  CHECK_FALSE(info.frozen_cue);
  CHECK(info.termination == Termination::kSuccess);
  CHECK(batch->options().control_mode == ControlMode::kPdJointDeltaPos);
  CHECK(batch->action_dim() == 8);
  CHECK_THROWS_WITH(make_task(id, {{"ACTION_L2_COEF", 0.1}}), Catch::Contains("ACTION_L2_COEF"));
  const std::unique_ptr<Task> longer = make_task(id, {{"max_episode_steps", 2 * horizon}});
  CHECK(longer->info().horizon == 2 * horizon);
  CHECK(longer->info().termination == Termination::kSuccess);
}

// Plays whole episodes, of each policy in turn, on through success; calls begin(env, index) after
// every reset and look(env, index) after every step, for every environment. Returns the numbers of
// steps and of successes.
template <class Look, class Begin = void (*)(const Batch&, int)>
std::pair<int, int> play_rl(
    const std::string& id, const Look& look,
    const Begin& begin = [](const Batch& /*env*/, int /*index*/) {}) {
  constexpr int kSteps = 5400;  // at least, of all policies
  constexpr int kPolicies = 3;
  const BatchOptions options{
      .num_envs = std::max(20, kSteps / (kPolicies * require_entry(id).horizon)),
      .threads = 2,
      .reward_mode = RewardMode::kDense,
      .auto_reset = AutoReset::kOff,
      .terminate_on_success = false};
  const auto batch = make_env(id, options);
  int steps = 0;
  int successes = 0;
  for (const Policy policy : {Policy::kOracle, Policy::kRandom, Policy::kBlind}) {
    batch->reset();
    for (int i = 0; i < options.num_envs; ++i) begin(*batch, i);
    for (int t = 1; t <= batch->info().horizon; ++t) {
      step(*batch, policy);
      for (int i = 0; i < options.num_envs; ++i) {
        look(*batch, i);
        successes += batch->outputs().success[static_cast<std::size_t>(i)];
        ++steps;
      }
    }
  }
  return {steps, successes};
}

// Actions of pd_ee_delta_pose that take every hand to the point that goal_of(index) gives.
template <class GoalOf>
std::vector<float> move_to(const Batch& batch, const GoalOf& goal_of) {
  std::vector<float> actions = zeros(batch);
  for (int i = 0; i < batch.num_envs(); ++i) {
    const Eigen::Vector3d tcp = Eigen::Map<const Eigen::Vector3d>(batch.state().tcp_pos.row(i));
    const Eigen::Vector3d command = 16 * (goal_of(i) - tcp);
    for (int k = 0; k < 3; ++k) {
      actions[static_cast<std::size_t>(i * batch.action_dim() + k)] =
          static_cast<float>(std::clamp(command[k], -1.0, 1.0));
    }
  }
  return actions;
}

// The number of `episodes` held-out episodes that a policy solves.
inline int solved_by(Policy policy, const std::string& id, ControlMode mode, int episodes) {
  const auto batch = make_running(id, {.num_envs = episodes,
                                       .seed = 1000,
                                       .threads = 2,
                                       .control_mode = mode,
                                       .auto_reset = AutoReset::kOff});
  for (int t = 0; t < batch->info().horizon; ++t) step(*batch, policy);
  int solved = 0;
  for (int i = 0; i < episodes; ++i) {
    solved += *row<std::uint8_t>(batch->output("success_once"), i);
  }
  return solved;
}

// The oracle's, in the modes in which RL tasks are used; `least` of 40 are enough.
inline void check_rl_oracle(const std::string& id, int least = 38) {
  for (const ControlMode mode : {ControlMode::kPdJointDeltaPos, ControlMode::kPdEeDeltaPose}) {
    INFO(id << ", " << name_of(mode));
    CHECK(solved_by(Policy::kOracle, id, mode, 40) >= least);
  }
}

}  // namespace engram::test
