// TakeItBack as an RL task.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tasks/take_it_back/task.h"
#include "tests/tasks/rl_episodes.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::row;
using Vector = Eigen::Vector3d;

constexpr const char* kId = "TakeItBack-v0";
constexpr tasks::TakeItBackShaping kShaping = {
    .in_place = 0.01, .in_goal_weight = 0, .contact_weight = 0};

TEST_CASE("TakeItBack as an RL task has the published facts", "[take_it_back][rl]") {
  CHECK(test::rl_ids("TakeItBack") == std::vector<std::string>{kId});
  test::check_rl_facts(kId, 180, "Spatial");
  const auto batch = make_env(kId);
  CHECK(batch->info().success_reward == 30);
  CHECK(batch->state_dim() == 39);
  CHECK(test::names_of(batch->info().reward_terms) ==
        std::vector<std::string>{"reached_push", "reached_pull", "tcp_push_dist", "tcp_pull_dist",
                                 "reaching_reward_push", "reaching_reward_pull", "goal_achieved",
                                 "goal_reached_status", "place_in_goal_reward",
                                 "place_back_reward"});
  for (const TaskConstant& constant : batch->info().constants) {
    CHECK(constant.name.find("_COEF") == std::string::npos);
  }
}

TEST_CASE("The reward of TakeItBack as an RL task equals its published values",
          "[take_it_back][rl]") {
  const auto reward = [](Vector cube, Vector tcp, bool reached) {
    tasks::TakeItBackReward in{.cube = cube,
                               .tcp = tcp,
                               .goal = {0.22, 0},
                               .initial = {0, 0.1},
                               .reached = reached,
                               .smoothness = {},
                               .shaping = kShaping};
    return Approx(in.compute()).margin(1e-6);
  };
  CHECK(0.160261 == reward({0, 0.1, 0.02}, {-0.0707, 0, 0.318}, false));
  CHECK(4.091661 == reward({0.1, 0.05, 0.02}, {0.07, 0.05, 0.02}, false));
  CHECK(8.267648 == reward({0.16, 0.02, 0.02}, {0.155, 0.02, 0.02}, true));
  CHECK(16.217211 == reward({0.12, 0.04, 0.02}, {0.15, 0.04, 0.02}, true));
}

TEST_CASE("The cube back in its place ends an RL episode, unless the user wants it to go on",
          "[take_it_back][rl]") {
  for (const bool ends : {true, false}) {
    BatchOptions options{
        .reward_mode = RewardMode::kDense, .auto_reset = AutoReset::kOff, .substeps = 0};
    if (!ends) options.terminate_on_success = false;
    options.pins = {{"slot", {0.0}},
                    {"initial_x", {0.0}},
                    {"initial_shift", {0.02}},
                    {"goal_x", {0.22}},
                    {"goal_y", {0.0}}};
    const auto batch = make_running(kId, options);
    const auto step = [&](double x, double y) {
      double* pos = batch->state().prop_pos_of(0, 0);
      pos[0] = x;
      pos[1] = y;
      test::step(*batch, Policy::kZero);
    };
    step(0, 0.02);
    CHECK(batch->outputs().success[0] == 0);
    step(0.22, 0);
    CHECK(batch->outputs().terminated[0] == 0);
    CHECK(*row<std::uint8_t>(batch->output("goal_reached_status"), 0) == 1);
    step(0, 0.02 + 0.0801);
    CHECK(batch->outputs().terminated[0] == 0);
    step(0, 0.02 + 0.0799);
    CHECK(batch->outputs().success[0] == 1);
    CHECK(batch->outputs().reward[0] == 30);
    CHECK(batch->outputs().terminated[0] == (ends ? 1 : 0));
    CHECK(batch->outputs().truncated[0] == 0);
  }
}

// The published formula, from the state alone; reached: the latch of the environment's episode.
double published_reward(const Batch& batch, int i, bool& reached) {
  const State& state = batch.state();
  const auto pos = [&](int prop) -> Vector {
    return Eigen::Map<const Vector>(state.prop_pos_of(i, prop));
  };
  const Vector cube = pos(0);
  const Vector tcp = Eigen::Map<const Vector>(state.tcp_pos.row(i));
  const double to_start = (cube - pos(1)).head<2>().norm();
  const double to_goal = (cube - pos(2)).head<2>().norm();
  reached = reached || to_goal < 0.08;
  if (reached && to_start < 0.08) return 30;
  const double push = (cube + Vector(-0.025, 0, 0) - tcp).norm();
  const double pull = (cube + Vector(0.03, 0, 0) - tcp).norm();
  if (reached) {
    return 10 * (1 - std::tanh(5 * pull)) + (pull < 0.01 ? 15 * (1 - std::tanh(5 * to_start)) : 0);
  }
  return 2 * (1 - std::tanh(5 * push)) + (push < 0.01 ? 5 * (1 - std::tanh(5 * to_goal)) : 0);
}

TEST_CASE("Rewards of TakeItBack as an RL task are those of the published formula over 5,000 steps",
          "[take_it_back][rl]") {
  std::vector<std::uint8_t> reached(20);
  int returning = 0;
  const auto look = [&](const Batch& batch, int i) {
    const auto at = static_cast<std::size_t>(i);
    bool latch = batch.state().elapsed[i] > 1 && reached[at] != 0;
    const auto reward = static_cast<double>(batch.outputs().reward[at]);
    CHECK(reward == Approx(published_reward(batch, i, latch)).margin(1e-5));
    reached[at] = latch ? 1 : 0;
    returning += latch && reward < 30 ? 1 : 0;
  };
  const auto [steps, successes] = test::play_rl(kId, look);
  CHECK(steps >= 5000);
  CHECK(successes > 100);
  CHECK(returning > 100);
}

// The terms of a hand in its place, which the oracle's never is.
TEST_CASE("A hand behind the cube, or before it, earns the published bonus", "[take_it_back][rl]") {
  const BatchOptions options{.num_envs = 8,
                             .reward_mode = RewardMode::kDense,
                             .control_mode = ControlMode::kPdEeDeltaPose};
  for (const double dx : {-0.025, 0.03}) {
    const auto batch = make_running(kId, options);
    int bonuses = 0;
    for (int t = 1; t < 60; ++t) {
      batch->step(test::move_to(*batch, [&](int i) -> Vector {
        return Eigen::Map<const Vector>(batch->state().prop_pos_of(i, 0)) + Vector(dx, 0, 0);
      }));
      for (int i = 0; i < options.num_envs; ++i) {
        bool reached = *row<std::uint8_t>(batch->output("goal_reached_status"), i) != 0;
        const auto reward =
            static_cast<double>(batch->outputs().reward[static_cast<std::size_t>(i)]);
        CHECK(reward == Approx(published_reward(*batch, i, reached)).margin(1e-5));
        bonuses += reward > 2 ? 1 : 0;
      }
    }
    if (dx < 0) CHECK(bonuses > 0);
  }
}

TEST_CASE("The oracle solves TakeItBack as an RL task in both of its usual modes",
          "[take_it_back][rl][oracle]") {
  test::check_rl_oracle(kId);
}

}  // namespace
}  // namespace engram
