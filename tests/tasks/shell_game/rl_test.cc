// The RL ids of the shell games: what differs from the VLA ids, and their rewards worked out again.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include "core/sim/control_mode.h"
#include "tasks/shell_game/pick_rl.h"
#include "tasks/shell_game/push.h"
#include "tasks/shell_game/touch_rule.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/shell_game/ids.h"
#include "tests/tasks/spectator.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::Point, test::row, test::Spectator;
using namespace test::shell_game;

constexpr const char* kIds[] = {kTouchRl, kPushRl, kPickRl};
constexpr double kRest = 0.0407278;  // m, of a mug's origin
constexpr int kCue = 5;
constexpr int kBall = 3;
constexpr int kGoal = 4;

Point pos(const Batch& batch, int prop, int index = 0) { return Spectator(batch, index).pos(prop); }

// --- scene, phases ---

TEST_CASE("RL shell games show the ball for five steps, then mugs of the scan's size",
          "[shell][rl]") {
  for (const char* id : kIds) {
    const auto batch =
        make_running(id, {.pins = {{"base", {0.05, -0.03}}, {"cup_with_ball_number", {2}}}});
    for (int t = 0; t <= 8; ++t) {
      INFO(id << ", t " << t);
      for (int mug = 0; mug < 3; ++mug) {
        const Point slot(0.05, -0.03 + (mug - 1) * 0.2, kRest);
        CHECK((pos(*batch, mug) - slot - Point(0, 0, t < kCue ? 1000 : 0)).norm() < 1e-6);
        CHECK(Spectator(*batch, 0).hidden(mug) == (t < kCue));
      }
      CHECK((pos(*batch, kBall) - Point(0.05, 0.17, 0.02)).norm() < 1e-12);
      CHECK_FALSE(Spectator(*batch, 0).hidden(kBall));
      CHECK(*row<std::int32_t>(batch->output("oracle_info"), 0) == 2);
      test::step(*batch, Policy::kZero);
    }
    const PropModel& mug = batch->physics_model().props()[0];
    CHECK(mug.mass == Approx(0.3 / 2.197).epsilon(1e-3));
  }
}

TEST_CASE("RL shell games let the arm move from the first action on, by its joints",
          "[shell][rl]") {
  for (const char* id : kIds) {
    INFO(id);
    const auto batch = make_env(id);
    CHECK(batch->options().control_mode == ControlMode::kPdJointDeltaPos);
    CHECK(batch->action_dim() == 8);
    CHECK(batch->info().horizon == 90);
    CHECK(batch->info().memory_type == "Object");
    CHECK(batch->info().split == "rl");
    CHECK_FALSE(batch->info().canonical);
    CHECK_FALSE(batch->info().frozen_cue);
    CHECK(batch->info().termination == Termination::kSuccess);
    batch->reset();
    const double before = batch->state().qpos.row(0)[0];
    std::vector<float> action = test::zeros(*batch);
    action[0] = 1;
    batch->step(action);
    CHECK(batch->state().qpos.row(0)[0] - before > 0.01);
  }
}

TEST_CASE("The goal regions of the RL shell games", "[shell][rl]") {
  for (const char* id : {kPushRl, kPickRl}) {
    const auto batch =
        make_running(id, {.pins = {{"base", {0.05, -0.03}}, {"cup_with_ball_number", {0}}}});
    const Point goal =
        id == kPushRl ? Point(0.15, -0.23, 0.0442722) : Point(0.05, -0.23, 0.1442722);
    CHECK((pos(*batch, kGoal) - goal).norm() < 1e-9);
  }
}

// Direction of a mug's handle in the world, degrees.
double handle_direction(const Batch& batch, int mug, int index = 0) {
  const double* q = batch.state().prop_quat_of(index, mug);
  const Eigen::Quaterniond turned(q[0], q[1], q[2], q[3]);
  CHECK(turned.norm() == Approx(1).margin(1e-12));
  const double yaw = -34.1 * std::numbers::pi / 180;
  const Point handle = turned * Point(std::cos(yaw), std::sin(yaw), 0);
  return std::atan2(handle.y(), handle.x()) * 180 / std::numbers::pi;
}

TEST_CASE("Handles of RL mugs point to the right, those of ShellGamePick to the robot",
          "[shell][rl]") {
  for (const char* id : {kTouchRl, kPushRl}) {
    const auto batch = make_running(id);
    for (int mug = 0; mug < 3; ++mug) {
      CHECK(handle_direction(*batch, mug) == Approx(87.2).margin(0.1));
    }
  }
  const double directions[] = {167.1, 170.5, 173.5};
  for (int handle = 0; handle < 3; ++handle) {
    const auto batch = make_running(kPickRl, {.pins = {{"handle", {1.0 * handle}}}});
    for (int t = 0; t < 7; ++t) {
      for (int mug = 0; mug < 3; ++mug) {
        CHECK(handle_direction(*batch, mug) == Approx(directions[handle]).margin(0.1));
      }
      test::step(*batch, Policy::kZero);
    }
  }
}

TEST_CASE("The handles of ShellGamePick tell nothing of the ball, but by upstream_handle",
          "[shell][rl][leak]") {
  for (const bool upstream : {false, true}) {
    const BatchOptions options{.num_envs = 1800,
                               .task_options = {{"upstream_handle", upstream ? 1.0 : 0.0}}};
    const auto batch = make_running(kPickRl, options);
    std::map<std::pair<int, int>, int> counts;
    for (int i = 0; i < options.num_envs; ++i) {
      const int slot = *row<std::int32_t>(batch->output("oracle_info"), i);
      ++counts[{slot, static_cast<int>(std::lround(handle_direction(*batch, 0, i)))}];
    }
    if (upstream) {
      CHECK(counts.size() == 3);
      for (const auto& [slot, direction] : {std::pair{0, 167}, {1, 173}, {2, 170}}) {
        CHECK(counts.contains({slot, direction}));
      }
      CHECK(batch->info().chance() == 1);
    } else {
      CHECK(counts.size() == 9);
      for (const auto& [kind, count] : counts) CHECK(std::abs(count - 200) < 67);
      CHECK(batch->info().chance() == Approx(1.0 / 3));
    }
  }
  // A pinned handle is obeyed under the option, too.
  const auto batch =
      make_running(kPickRl, {.pins = {{"handle", {1}}, {"cup_with_ball_number", {0}}},
                             .task_options = {{"upstream_handle", 1}}});
  CHECK(handle_direction(*batch, 0) == Approx(170.5).margin(0.1));
}

// --- success ---

// One environment without physics, whose mug 1 hides the ball.
struct Still {
  std::unique_ptr<Batch> batch;

  explicit Still(const char* id, bool terminates = false) {
    const BatchOptions options{.reward_mode = RewardMode::kSparse,
                               .auto_reset = AutoReset::kOff,
                               .terminate_on_success = terminates,
                               .substeps = 0,
                               .pins = {{"base", {0, 0}}, {"cup_with_ball_number", {1}}}};
    batch = make_env(id, options);
    batch->reset();
  }
  void wait(int until) const {
    while (batch->state().elapsed[0] < until) test::step(*batch, Policy::kZero);
  }
  bool step(double speed) const {
    batch->state().qvel.row(0)[3] = speed;
    test::step(*batch, Policy::kZero);
    CHECK(batch->outputs().reward[0] == static_cast<float>(batch->outputs().success[0]));
    return batch->outputs().success[0] != 0;
  }
  // After a step with the mug so far from its slot.
  bool moved(const Point& way, double speed = 0, int mug = 1) const {
    const Point there = Point(0, 0.2 * (mug - 1), kRest) + way;
    std::copy_n(there.data(), 3, batch->state().prop_pos_of(0, mug));
    return step(speed);
  }
  // After a step with the tool so far above the mug's origin.
  bool above(double height, double speed = 0) const {
    test::pose_tool(*batch, Point(0, 0, kRest + height));
    return step(speed);
  }
};

TEST_CASE("RL Touch asks for phase, distance and stillness, not for mugs in their places",
          "[shell][rl]") {
  const Still game(kTouchRl);
  game.wait(kCue - 2);
  test::pose_tool(*game.batch, Point(0, 0, kRest + 0.07));
  CHECK_FALSE(game.step(0));  // step 4: the cue
  CHECK(game.step(0));        // step 5: the mugs are there
  CHECK(game.above(0.08 - 1e-6, 0.2));
  CHECK_FALSE(game.above(0.08 + 1e-6));
  CHECK_FALSE(game.above(0.07, 0.2001));
  game.batch->state().prop_pos_of(0, 0)[0] += 0.3;
  CHECK(game.above(0.07));
}

TEST_CASE("RL Push and Pick ask for the mug at the goal, after the first step with mugs",
          "[shell][rl]") {
  const Still push(kPushRl);
  push.wait(kCue - 1);
  CHECK_FALSE(push.moved({0.1, 0, 0}));  // step 5; the task puts it back
  CHECK(push.moved({0.0202, 0, 0}));
  CHECK_FALSE(push.moved({0.0200, 0, 0}));
  CHECK(push.moved({0.1798, 0, 0}, 0.2));
  CHECK_FALSE(push.moved({0.1800, 0, 0}));
  CHECK_FALSE(push.moved({0.1, 0, 0}, 0.2001));
  push.moved({0, 0, 0});
  CHECK_FALSE(push.moved({0.1, 0, 0}, 0, 0));

  const Still pick(kPickRl);
  pick.wait(kCue);
  CHECK_FALSE(pick.moved({0, 0, 0.0235}));
  CHECK(pick.moved({0, 0, 0.0236}));
  CHECK(*row<std::uint8_t>(pick.batch->output("is_grasped"), 0) == 0);
  CHECK_FALSE(pick.moved({0, 0, 0.1}, 0.2001));
  // The ball stays behind.
  CHECK(pick.moved({0.01, 0, 0.1}));
  CHECK(pos(*pick.batch, kBall).z() == Approx(0.02));
}

TEST_CASE("Success ends RL shell games, unless that is switched off", "[shell][rl]") {
  for (const bool ends : {true, false}) {
    for (const char* id : {kPushRl, kPickRl}) {
      const Still game(id, ends);
      game.wait(kCue);
      REQUIRE(game.moved(id == kPushRl ? Point(0.1, 0, 0) : Point(0, 0, 0.1)));
      CHECK((game.batch->outputs().terminated[0] != 0) == ends);
      CHECK(game.batch->outputs().truncated[0] == 0);
    }
    const Still touch(kTouchRl, ends);
    touch.wait(kCue);
    REQUIRE(touch.above(0.07));
    CHECK((touch.batch->outputs().terminated[0] != 0) == ends);
  }
}

// --- observations, infos ---

TEST_CASE("State observations of RL shell games have the published fields", "[shell][rl]") {
  using Fields = std::vector<std::string>;
  const std::map<std::string, std::pair<int, Fields>> table = {
      {kTouchRl, {40, {"obj_pose", "ball_pose", "oracle_info"}}},
      {kPushRl, {43, {"goal_pos", "obj_pose", "ball_pose", "oracle_info"}}},
      {kPickRl, {44, {"goal_pos", "obj_pose", "ball_pose", "oracle_info", "is_grasped"}}}};
  for (const auto& [id, row] : table) {
    INFO(id);
    const auto batch = make_env(id);
    CHECK(batch->state_dim() == row.first);
    Fields names;
    for (const Field& field : batch->info().state_fields) names.push_back(field.name);
    CHECK(names == row.second);
    const Fields lacking = {"mug_max_displacement", "is_mug_displacement_ok"};
    for (const std::string& name : lacking)
      CHECK(test::columns_of(*batch).find(name).field == nullptr);
    CHECK((test::columns_of(*batch).find("is_grasped").field != nullptr) == (id == kPickRl));
  }
}

TEST_CASE("reward_dict of RL shell games has the published keys", "[shell][rl]") {
  using Names = std::vector<std::string>;
  const std::map<std::string, std::pair<double, Names>> table = {
      {kTouchRl,
       {3, {"reaching_reward", "static_reward", "tcp_to_obj_dist", "info[\"is_obj_placed\"]"}}},
      {kPushRl,
       {4,
        {"reaching_reward", "static_reward", "place_reward", "tcp_to_obj_dist", "obj_to_goal_dist",
         "info[\"is_obj_placed\"]", "reached_status"}}},
      {kPickRl,
       {75,
        {"reaching_reward", "reached_status", "info[\"is_grasped\"]", "place_reward",
         "static_reward", "tcp_to_obj_dist", "obj_to_goal_dist", "info[\"is_obj_placed\"]", "dx",
         "dy", "dz"}}}};
  for (const auto& [id, row] : table) {
    INFO(id);
    const auto task = make_task(id);
    Names names;
    for (const Field& term : task->info().reward_terms) names.push_back(term.name);
    CHECK(names == row.second);
    CHECK(task->info().success_reward == row.first);
  }
}

TEST_CASE("The cue of RL shell games is a range that users may change", "[shell][rl][variants]") {
  for (const char* id : kIds) {
    INFO(id);
    const auto described = published_constants(make_task(id)->info().constants);
    const auto value = [&](const char* name) {
      const auto found =
          std::ranges::find(described, name, [](const auto& entry) { return entry.first; });
      REQUIRE(found != described.end());
      return found->second;
    };
    CHECK(value("TIME_OFFSET") == Constant(5));
    CHECK(value("MUG_SCALE") == Constant(1.0));
    const MakeOptions options{{.num_envs = 60}, {{"CUE_PHASE_STEPS", ConstantList{7, 12}}}};
    const auto batch = make_running(id, options);
    std::map<int, int> lengths;
    for (int i = 0; i < options.num_envs; ++i) {
      ++lengths[*row<std::int32_t>(test::memory_of(*batch).find("cue_steps"), i)];
    }
    CHECK(lengths.begin()->first == 7);
    CHECK(lengths.rbegin()->first == 12);
  }
}

// --- rewards ---

TEST_CASE("Rewards of RL shell games equal the worked values", "[shell][rl]") {
  using tasks::TouchRule;
  CHECK(TouchRule::Reward{0.2, 0.6, 0, false, false, true, false}.compute() ==
        Approx(0.238406).margin(1e-6));
  CHECK(TouchRule::Reward{0.07, 0.3, 0, false, true, true, false}.compute() ==
        Approx(0.758476).margin(1e-6));
  const std::array<std::pair<tasks::PushReward, double>, 3> pushes = {{
      {{0.15, 0.1, 0.4, false, false, true, false}, 0.094852},
      {{0.07, 0.1, 0.4, false, false, true, false}, 1.471398},
      {{0.07, 0.05, 0.6, false, true, true, false}, 1.906784},
  }};
  for (auto [in, reward] : pushes) {
    CHECK(in.compute() == Approx(reward).margin(1e-6));
  }
  const auto pick = [](double distance, double to_goal, double speed, bool still) {
    tasks::MugPickReward in{.to_goal = to_goal,
                            .arm_speed = speed,
                            .robot_static = still,
                            .placed = to_goal <= 0.08,
                            .manipulation = true,
                            .offset = {0, 0, distance}};
    return in.compute();
  };
  CHECK(pick(0.1, 0.1042722, 0.4, false) == Approx(0.715218).margin(1e-6));
  CHECK(pick(0.03, 0.1042722, 0.1, true) == Approx(19.763570).margin(1e-6));
  CHECK(pick(0.03, 0.07, 0.4, false) == Approx(24.214658).margin(1e-6));
}

// The formulas of the reward once more, from what a spectator sees.
struct RewardAgain {
  std::string id;

  double operator()(const Spectator& scene) const {
    const int slot = scene.info_int("oracle_info");
    const Point mug = scene.pos(slot);
    const double d = (mug - scene.tcp()).norm();
    double squares = 0;
    for (int joint = 0; joint < 7; ++joint) {
      squares += std::pow(scene.state().qvel.row(scene.index())[joint], 2);
    }
    const double slow = 1 - std::tanh(5 * std::sqrt(squares));
    const double still = scene.still(0.2) ? 1 : 0;
    const bool acting = scene.elapsed() >= 5;
    if (id == kTouchRl) {
      const double placed = d <= 0.08 ? 1 : 0;
      if (acting && placed * still > 0) return 3;
      return acting ? 1 - std::tanh(5 * d) + slow * placed + still * placed : 0;
    }
    const double g = (scene.pos("goal_site") - mug).norm();
    const double placed = g <= 0.08 ? 1 : 0;
    const bool success = placed * still > 0 && scene.elapsed() > 5;
    const double place = 1 - std::tanh(5 * g);
    if (id == kPushRl) {
      if (success) return 4;
      const double near = d <= 0.08 ? 1 : 0;
      return acting ? 1 - std::tanh(10 * d) + 2 * place * near + 0.2 * (slow + still) * placed : 0;
    }
    if (success) return 75;
    const double near = d <= 0.04 ? 1 : 0;
    return acting ? 3 * (1 - std::tanh(10 * d)) + 2 * near + 30 * place * near +
                        5 * (slow + still) * placed * near
                  : 0;
  }
};

TEST_CASE("Rewards of RL shell games equal their formulas in 5,000 steps", "[shell][rl]") {
  constexpr int kEnvs = 20;
  for (const char* id : kIds) {
    const auto batch = make_env(id, {.num_envs = kEnvs,
                                     .reward_mode = RewardMode::kDense,
                                     .auto_reset = AutoReset::kOff,
                                     .terminate_on_success = false});
    const RewardAgain formula{id};
    int compared = 0;
    int successes = 0;
    for (const Policy policy : {Policy::kOracle, Policy::kBlind, Policy::kRandom}) {
      batch->reset();
      for (int t = 1; t <= batch->info().horizon; ++t) {
        test::step(*batch, policy);
        for (int i = 0; i < kEnvs; ++i) {
          const double given =
              static_cast<double>(batch->outputs().reward[static_cast<std::size_t>(i)]);
          const double expected = formula(Spectator(*batch, i));
          INFO(id << ", " << name_of(policy) << ", environment " << i << ", step " << t);
          CHECK(given == Approx(expected).margin(1e-5));
          successes += batch->outputs().success[static_cast<std::size_t>(i)];
          ++compared;
        }
      }
    }
    CHECK(compared >= 5000);
    CHECK(successes > 100);
  }
}

// --- policies ---

// Share of episodes with success.
double success_rate(const char* id, Policy policy, ControlMode mode, int episodes = 100) {
  const auto batch = make_running(id, {.num_envs = episodes,
                                       .seed = 1000,
                                       .threads = 2,
                                       .control_mode = mode,
                                       .auto_reset = AutoReset::kOff});
  for (int t = 0; t < batch->info().horizon; ++t) test::step(*batch, policy);
  int successes = 0;
  for (int i = 0; i < episodes; ++i) {
    successes += *row<std::uint8_t>(batch->output("success_once"), i);
  }
  return successes / static_cast<double>(episodes);
}

TEST_CASE("The oracle solves RL shell games in both spaces of actions", "[shell][rl][oracle]") {
  for (const char* id : kIds) {
    for (const ControlMode mode : {ControlMode::kPdJointDeltaPos, ControlMode::kPdEeDeltaPose}) {
      INFO(id << ", " << name_of(mode));
      CHECK(success_rate(id, Policy::kOracle, mode) >= 0.95);
      CHECK(std::abs(success_rate(id, Policy::kBlind, mode) - 1.0 / 3) <= 0.15);
    }
    CHECK(success_rate(id, Policy::kZero, ControlMode::kPdJointDeltaPos) == 0);
  }
}

}  // namespace
}  // namespace engram
