// RememberColor, RememberShape and RememberShapeAndColor as RL tasks.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tasks/remember/find_same.h"
#include "tests/tasks/remember/recall_env.h"
#include "tests/tasks/rl_episodes.h"

namespace engram {
namespace {

using test::count_of, test::make_env, test::make_running, test::memory_int, test::object_pos,
    test::Part, test::stored_pos;

constexpr int kCueEnd = 5;
constexpr int kReveal = 10;
constexpr int kHorizon = 60;

TEST_CASE("The RL tasks of Remember are those of the published list", "[remember][rl]") {
  CHECK(test::ids_of("Remember", Part::kRl) ==
        std::vector<std::string>{"RememberColor3-v0", "RememberColor5-v0", "RememberColor9-v0",
                                 "RememberShape3-v0", "RememberShape5-v0", "RememberShape9-v0",
                                 "RememberShapeAndColor3x2-v0", "RememberShapeAndColor3x3-v0",
                                 "RememberShapeAndColor5x3-v0"});
  for (const std::string& id : test::ids_of("Remember", Part::kRl)) {
    test::check_rl_facts(id, kHorizon, "Object");
  }
}

TEST_CASE("RL tasks of Remember show the cue for five steps and nothing for five",
          "[remember][rl]") {
  for (const std::string& id : test::ids_of("Remember", Part::kRl)) {
    const auto batch = make_env(id, {.auto_reset = AutoReset::kOff});
    const tasks::ObjectSet objects = test::objects_of(*batch);
    batch->reset();
    const int target = memory_int(*batch, "target");
    for (int t = 0; t <= kHorizon; ++t) {
      INFO(id << ", t " << t);
      for (int key = 0; key < count_of(*batch); ++key) {
        CHECK(test::is_visible(*batch, key) == (t >= kReveal || (t < kCueEnd && key == target)));
        Eigen::Vector3d expected = stored_pos(*batch, key);
        if (t < kReveal) {
          if (key == target) expected.head<2>().setZero();
          const bool shown = t < kCueEnd && key == target;
          expected.z() = shown ? objects.resting_height(key) : 1000;
        }
        CHECK(object_pos(*batch, key) == expected);
      }
      CHECK(batch->outputs().terminated[0] == 0);
      CHECK(batch->outputs().truncated[0] == (t == kHorizon ? 1 : 0));
      if (t < kHorizon) batch->step(test::zeros(*batch));
    }
  }
}

TEST_CASE("The arm moves from the first action on in RL tasks", "[remember][rl]") {
  const auto batch = make_running("RememberColor3-v0");
  const double before = batch->state().qpos.row(0)[0];
  std::vector<float> action = test::zeros(*batch);
  action[0] = 1;
  batch->step(action);
  CHECK(batch->state().qpos.row(0)[0] > before + 0.02);
}

TEST_CASE("Rows of three are not stretched in RL tasks", "[remember][rl]") {
  for (const char* id : {"RememberColor3-v0", "RememberShape3-v0"}) {
    const BatchOptions options{.num_envs = 500};
    const auto batch = make_running(id, options);
    double farthest = 0;
    double sum = 0;
    for (int i = 0; i < options.num_envs; ++i) {
      const auto y = [&](int key) { return stored_pos(*batch, key, i).y(); };
      sum += std::max({y(0), y(1), y(2)}) - std::min({y(0), y(1), y(2)});
      for (int key = 0; key < 3; ++key) farthest = std::max(farthest, std::abs(y(key)));
    }
    INFO(id);
    CHECK(sum / options.num_envs == Approx(0.2).margin(0.03));
    CHECK(farthest < 0.145);
  }
}

TEST_CASE("Objects that are pushed or turned after the reveal stay so in RL tasks",
          "[remember][rl]") {
  for (const char* id : {"RememberColor5-v0", "RememberShape9-v0", "RememberShapeAndColor3x3-v0"}) {
    const auto batch = make_running(id);
    for (int t = 1; t <= kReveal; ++t) batch->step(test::zeros(*batch));
    const double away[3] = {0.3, 0.3, 0.02};
    const double turned[4] = {0, 0, 0, 1};
    batch->state().place_prop(0, 1, away, turned);
    batch->step(test::zeros(*batch));
    INFO(id);
    CHECK((object_pos(*batch, 1) - stored_pos(*batch, 1)).norm() > 0.1);
    CHECK(batch->state().prop_quat_of(0, 1)[0] != 1);
  }
}

// Puts the target at a distance from the tool, lets a step pass, and tells whether that is success.
bool succeeds(Batch& batch, double distance, double speed) {
  const State& state = batch.state();
  const Eigen::Vector3d tcp = Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(0));
  const Eigen::Vector3d pos = tcp + Eigen::Vector3d(0, 0, distance);
  std::copy_n(pos.data(), 3, state.prop_pos_of(0, memory_int(batch, "target")));
  state.qvel.row(0)[3] = speed;
  batch.step(test::zeros(batch));
  state.qvel.row(0)[3] = 0;
  return batch.outputs().success[0] != 0;
}

TEST_CASE("Success ends an episode of an RL task, unless the user wants it to go on",
          "[remember][rl]") {
  for (const bool ends : {true, false}) {
    BatchOptions options;
    options.substeps = 0;  // the robot stays where the test puts it
    options.auto_reset = AutoReset::kOff;
    options.after_end = AfterEnd::kContinue;
    if (!ends) options.terminate_on_success = false;
    const auto batch = make_running("RememberColor3-v0", options);
    for (int t = 1; t < kReveal; ++t) batch->step(test::zeros(*batch));
    batch->step(test::zeros(*batch));
    CHECK_FALSE(succeeds(*batch, 0.0501, 0));
    CHECK_FALSE(succeeds(*batch, 0.03, 0.2001));
    CHECK(batch->outputs().terminated[0] == 0);
    CHECK(succeeds(*batch, 0.0499, 0.2));
    CHECK(batch->outputs().terminated[0] == (ends ? 1 : 0));
    CHECK(batch->outputs().truncated[0] == 0);
    CHECK(batch->outputs().reward[0] == 1);
  }
}

TEST_CASE("To rest at the object of the cue is no success in RL tasks", "[remember][rl]") {
  const auto batch = make_running("RememberColor3-v0", {.substeps = 0});
  const State& state = batch->state();
  for (int t = 1; t < kReveal; ++t) {
    // The tool is where the cue is.
    const double center[3] = {0, 0, 0.02};
    std::copy_n(center, 3, state.tcp_pos.row(0));
    batch->step(test::zeros(*batch));
    CHECK(batch->outputs().success[0] == 0);
  }
}

TEST_CASE("RL tasks of Remember tell no action cost", "[remember][rl]") {
  const std::vector<std::string> expected = {
      "tcp_to_obj_dist", "reaching_reward", "is_robot_static",   "reached",
      "success",         "static_reward",   "obj_to_goal_pos_y", "obj_to_goal_pos_x"};
  for (const std::string& id : test::ids_of("Remember", Part::kRl)) {
    const std::unique_ptr<Task> task = make_task(id);
    CHECK(test::names_of(task->info().reward_terms) == expected);
    CHECK(task->info().success_reward == 3);
  }
}

// The published formula, from the state alone: D to the target's origin, v the norm of the seven
// speeds.
double published_reward(const Batch& batch, int index) {
  const State& state = batch.state();
  const Eigen::Vector3d tcp = Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(index));
  const double distance =
      (object_pos(batch, memory_int(batch, "target", index), index) - tcp).norm();
  double square = 0;
  double fastest = 0;
  for (int k = 0; k < 7; ++k) {
    square += std::pow(state.qvel.row(index)[k], 2);
    fastest = std::max(fastest, std::abs(state.qvel.row(index)[k]));
  }
  const bool still = fastest <= 0.2;
  const bool placed = distance <= 0.05;
  if (still && placed && state.elapsed[index] >= kReveal) return 3;
  return 1 - std::tanh(10 * distance) + 0.5 * (1 - std::tanh(5 * std::sqrt(square))) +
         0.5 * (still && placed ? 1 : 0);
}

TEST_CASE("Rewards of RL tasks are those of the published formula over 5,000 steps",
          "[remember][rl]") {
  for (const char* id : {"RememberColor9-v0", "RememberShape5-v0", "RememberShapeAndColor3x2-v0"}) {
    const auto [steps, successes] = test::play_rl(id, [](const Batch& batch, int i) {
      CHECK(static_cast<double>(batch.outputs().reward[static_cast<std::size_t>(i)]) ==
            Approx(published_reward(batch, i)).margin(2e-6));
    });
    INFO(id);
    CHECK(steps >= 5000);
    CHECK(successes > 100);
  }
}

TEST_CASE("The oracle solves the RL tasks of Remember in both of its usual modes",
          "[remember][rl][oracle]") {
  for (const std::string& id : test::ids_of("Remember", Part::kRl)) {
    test::check_rl_oracle(id);
  }
}

}  // namespace
}  // namespace engram
