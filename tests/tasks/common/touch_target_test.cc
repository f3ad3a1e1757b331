#include "tasks/common/touch_target.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/env_helpers.h"

namespace engram::tasks {
namespace {

using test::row;

constexpr SmoothnessParams kColor = {0.02, 0.05, 0.01};

TEST_CASE("The touch reward has the worked values", "[reward]") {
  struct Row {
    const char* name;
    TouchReward in;
    double reach;
    double penalty;
    double reward;
    double normalized;
    double without_penalty;  // normalised, with zero coefficients
  };
  const Row rows[] = {
      {"hidden", {1000, 0, 0, 0, true, false, false}, 0, 0, 0.5, 0.166667, 0.166667},
      {"cue", {0.306, 0, 0, 0, true, false, false}, 0.004387, 0, 0.504387, 0.168129, 0.168129},
      {"approaching",
       {0.12, 0.6, 1.2, 0.3, false, false, false},
       0.166345,
       0.073267,
       0.095551,
       0.031850,
       0.056273},
      {"near",
       {0.06, 0.05, 0.1, 0.1, true, false, false},
       0.462950,
       0.028050,
       0.812441,
       0.270814,
       0.280164},
      {"placed, moving",
       {0.03, 0.5, 0.4, 0.8, false, true, false},
       0.708687,
       0.070863,
       0.644517,
       0.214839,
       0.238460},
      {"placed before M",
       {0.03, 0.05, 0.1, 0.1, true, true, false},
       0.708687,
       0.028050,
       1.558178,
       0.519393,
       0.528743},
      {"success", {0.03, 0.05, 0.1, 0.1, true, true, true}, 0.708687, 0.028050, 3, 1, 1},
  };
  for (Row line : rows) {
    TouchReward& reward = line.in;
    reward.smoothness = kColor;
    const double value = reward.compute();
    INFO(line.name);
    CHECK(reward.reaching == Approx(line.reach).margin(6e-7));
    CHECK(reward.smooth.penalty == Approx(line.penalty).margin(6e-7));
    CHECK(value == Approx(line.reward).margin(6e-7));
    CHECK(value / kTouchSuccessReward == Approx(line.normalized).margin(6e-7));
    reward.smoothness.reset();
    CHECK(reward.compute() / kTouchSuccessReward == Approx(line.without_penalty).margin(6e-7));
  }
}

// The reward of every step, worked out from what the environment shows.
double expected_reward(const Batch& batch, const std::vector<float>& action,
                       const std::vector<float>& previous, const SmoothnessParams& params) {
  const float* delta = row<float>(batch.output("obj_to_goal_pos"), 0);
  TouchReward in{.distance =
                     std::hypot(static_cast<double>(delta[0]), static_cast<double>(delta[1]),
                                static_cast<double>(delta[2]))};
  double speed = 0;
  double norm = 0;
  double change = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    speed += std::pow(batch.state().qvel.row(0)[i], 2);
    norm += std::pow(static_cast<double>(action[i]), 2);
    change += std::pow(static_cast<double>(action[i] - previous[i]), 2);
  }
  in.arm_speed = std::sqrt(speed);
  in.action_norm = std::sqrt(norm);
  in.action_delta_norm = batch.state().elapsed[0] <= 1 ? 0 : std::sqrt(change);
  in.robot_static = *row<std::uint8_t>(batch.output("is_robot_static"), 0) != 0;
  in.placed = *row<std::uint8_t>(batch.output("is_obj_placed"), 0) != 0;
  in.success = batch.outputs().success[0] != 0;
  in.smoothness = params;
  return in.compute();
}

TEST_CASE("Without action cost, the touch reward equals its published values", "[reward]") {
  const auto reward = [](double distance, double speed, bool still) {
    TouchReward in{.distance = distance,
                   .arm_speed = speed,
                   .action_norm = 1,
                   .action_delta_norm = 1,
                   .robot_static = still,
                   .placed = distance <= 0.05};
    return in.compute();
  };
  CHECK(reward(0.12, 0.6, false) == Approx(0.168818).margin(6e-7));
  CHECK(reward(0.06, 0.05, true) == Approx(0.840491).margin(6e-7));
  CHECK(reward(0.03, 0.5, false) == Approx(0.715380).margin(6e-7));
}

TEST_CASE("Steps pay the touch reward of what they show", "[reward]") {
  struct Row {
    const char* id;
    SmoothnessParams params;
  };
  const Row rows[] = {
      {"RememberColor5-VLA-v0", kColor},       {"FindImposterColor5-VLA-v0", kColor},
      {"RememberShape5-VLA-v0", kColor},       {"FindImposterShape5-VLA-v0", kColor},
      {"RememberShapeAndColor3x2-VLA-v0", {}}, {"FindImposterShapeAndColor3x2-VLA-v0", {}}};
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    const Row& task = rows[seed];
    INFO(task.id);
    const BatchOptions options{
        .seed = seed, .reward_mode = RewardMode::kDense, .freeze_cue = seed % 2 == 0};
    const auto batch = test::make_running(task.id, options);
    std::vector<float> previous(7);
    double total = 0;
    int successes = 0;
    for (int i = 0; i < 25; ++i) {
      // Between the oracle and something restless.
      std::vector<float> action = test::act(*batch, Policy::kOracle);
      if (i % 3 == 0 && i < 12) action[4] += 0.3F;
      const int freeze = *row<std::int32_t>(test::memory_of(*batch).find("cue_steps"), 0) +
                         *row<std::int32_t>(test::memory_of(*batch).find("empty_steps"), 0);
      const bool frozen = options.freeze_cue && batch->state().elapsed[0] < freeze;
      batch->step(action);
      if (frozen) action.assign(7, 0.0F);  // the reward sees the frozen action
      CHECK(batch->outputs().reward[0] ==
            Approx(expected_reward(*batch, action, previous, task.params)).margin(2e-6));
      previous = action;
      total += static_cast<double>(batch->outputs().reward[0]);
      successes += batch->outputs().success[0];
      if (batch->outputs().success[0] != 0) CHECK(batch->outputs().reward[0] == 3);
    }
    CHECK(successes > 0);
    CHECK(*row<double>(batch->output("episode_return"), 0) == Approx(total));
  }
}

TEST_CASE("The reward terms in the info are those of the step before", "[reward]") {
  const auto batch = test::make_env("RememberColor3-VLA-v0", {.reward_mode = RewardMode::kDense});
  std::vector<std::string> names;
  for (const Field& term : batch->info().reward_terms) names.push_back(term.name);
  REQUIRE(names.size() == 12);
  const auto term = [&](const char* name) {
    const auto index = std::find(names.begin(), names.end(), name) - names.begin();
    return row<float>(batch->output("reward_dict"), 0)[index];
  };
  batch->reset();
  CHECK(std::isnan(term("tcp_to_obj_dist")));
  test::step(*batch, Policy::kOracle);
  CHECK(std::isnan(term("tcp_to_obj_dist")));
  for (int i = 2; i < 20; ++i) {
    const float* delta = row<float>(batch->output("obj_to_goal_pos"), 0);
    const double distance = std::hypot(static_cast<double>(delta[0]), static_cast<double>(delta[1]),
                                       static_cast<double>(delta[2]));
    const float offset_y = delta[1];
    const bool success = batch->outputs().success[0] != 0;
    test::step(*batch, Policy::kOracle);
    CHECK(term("tcp_to_obj_dist") == Approx(distance).epsilon(1e-5));
    CHECK(term("obj_to_goal_pos_y") == offset_y);
    CHECK(term("success") == (success ? 1 : 0));
    CHECK(term("reaching_reward") == Approx(1 - std::tanh(10 * distance)).margin(1e-6));
  }
  const auto without =
      test::make_running("RememberColor3-VLA-v0", {.reward_mode = RewardMode::kSparse});
  for (int i = 0; i < 5; ++i) test::step(*without, Policy::kZero);
  CHECK(std::isnan(row<float>(without->output("reward_dict"), 0)[0]));
}

}  // namespace
}  // namespace engram::tasks
