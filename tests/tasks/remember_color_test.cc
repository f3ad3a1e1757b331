#include "tasks/remember_color.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env;
using test::row;

int cubes_of(const VectorEnv& env) { return env.info().candidates; }

int memory_int(const VectorEnv& env, const char* name, int index = 0) {
  return *row<std::int32_t>(env.memory().find(name), index);
}

Eigen::Vector3d cube(const VectorEnv& env, int key, int index = 0) {
  return Eigen::Map<Eigen::Vector3d>(env.state().prop_pos_of(index, key));
}

Eigen::Vector3d layout(const VectorEnv& env, int key, int index = 0) {
  return Eigen::Map<const Eigen::Vector3d>(row<double>(env.memory().find("positions"), index) +
                                           3 * key);
}

// Checks who is where in the phase of the present step.
void check_phase(const VectorEnv& env, int cue, int empty) {
  const int t = env.state().elapsed[0];
  const int target = memory_int(env, "target");
  const bool manipulation = t >= cue + empty;
  INFO("t " << t << ", cue " << cue << ", empty " << empty);
  for (int key = 0; key < cubes_of(env); ++key) {
    const bool visible = manipulation || (t < cue && key == target);
    CHECK((env.state().status_of(0, key) != PropStatus::kHidden) == visible);
    Eigen::Vector3d expected = layout(env, key);
    if (!manipulation) expected.z() = 1000;
    if (!manipulation && key == target) expected = {0, 0, t < cue ? 0.02 : 1000};
    CHECK(cube(env, key) == expected);
    CHECK(env.state().prop_quat_of(0, key)[0] == 1);
    CHECK(prop_is_static(env.state(), 0, key, 0, 0));
  }
  const float* offset = row<float>(env.output("obj_to_goal_pos"), 0);
  for (int i = 0; i < 3; ++i) {
    CHECK(offset[i] == Approx(cube(env, target)[i] - env.state().tcp_pos.row(0)[i]));
  }
  const auto observation = env.observation();
  CHECK(observation[25] == static_cast<float>(target));
  for (int key = 0; key < cubes_of(env); ++key) {
    for (int i = 0; i < 3; ++i) {
      const float shown = observation[static_cast<std::size_t>(26 + 3 * key + i)];
      CHECK(shown == (key == target ? static_cast<float>(cube(env, key)[i]) : 0.0F));
    }
  }
}

TEST_CASE("The worked example runs through its phases", "[remember_color]") {
  EnvOptions options;
  options.pins = {{"cue_steps", {2}}, {"empty_steps", {3}}};
  for (const char* id :
       {"RememberColor3-VLA-v0", "RememberColor5-VLA-v0", "RememberColor9-VLA-v0"}) {
    const auto env = make_env(id, options);
    env->reset();
    check_phase(*env, 2, 3);
    double opening = static_cast<double>(env->proprio()[6]);
    for (int t = 1; t <= 25; ++t) {
      env->step(std::vector<float>{0, 0, 0.2F, 0, 0, 0, 1});
      check_phase(*env, 2, 3);
      CHECK(env->truncated()[0] == (t == 25 ? 1 : 0));
      CHECK(env->terminated()[0] == 0);
      // Actions of the first five steps are zeroed: the gripper closes half. The sixth is live.
      const double now = static_cast<double>(env->proprio()[6]);
      CHECK((now < opening) == (t <= 5));
      opening = now;
      if (t == 8) break;  // opened again
    }
  }
}

TEST_CASE("Phases change at the drawn steps in every variant", "[remember_color]") {
  for (const std::string& id : test::implemented_ids()) {
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      EnvOptions options;
      options.seed = seed;
      const auto env = make_env(id, options);
      env->reset();
      const int cue = memory_int(*env, "cue_steps");
      const int empty = memory_int(*env, "empty_steps");
      check_phase(*env, cue, empty);
      for (int t = 1; t <= cue + empty + 1; ++t) {
        test::step(*env, Policy::kZero);
        const bool boundary = t <= 5 || std::abs(t - cue) <= 1 || t >= cue + empty - 1;
        if (boundary) check_phase(*env, cue, empty);
      }
    }
  }
}

TEST_CASE("Only the short variants freeze the cue", "[remember_color]") {
  for (const std::string& id : test::implemented_ids()) {
    const bool lengthy = id.find("Long") != std::string::npos;
    const auto env = make_env(id);
    CHECK(env->info().frozen_cue == !lengthy);
    env->reset();
    const int freeze = memory_int(*env, "cue_steps") + memory_int(*env, "empty_steps");
    CHECK(memory_int(*env, "freeze_steps") == (lengthy ? 0 : freeze));
  }
}

TEST_CASE("Targets and phase lengths are uniform over their ranges", "[remember_color]") {
  struct Ranges {
    int cubes, cue_low, cue_high, empty_low, empty_high;
  };
  const std::map<std::string, Ranges> table = {
      {"RememberColor3-VLA-v0", {3, 1, 5, 1, 5}},
      {"RememberColor5-VLA-v0", {5, 1, 5, 1, 5}},
      {"RememberColor9-VLA-v0", {9, 1, 5, 1, 5}},
      {"RememberColor3-Long-VLA-v0", {3, 10, 100, 50, 450}},
      {"RememberColor5-Long-VLA-v0", {5, 100, 100, 50, 450}},
      {"RememberColor9-Long-VLA-v0", {9, 100, 100, 50, 450}},
  };
  for (const auto& [id, ranges] : table) {
    EnvOptions options;
    options.num_envs = 4500;
    const auto env = make_env(id, options);
    env->reset();
    std::map<int, int> targets;
    std::map<int, int> cues;
    std::map<int, int> empties;
    for (int i = 0; i < options.num_envs; ++i) {
      ++targets[memory_int(*env, "target", i)];
      ++cues[memory_int(*env, "cue_steps", i)];
      ++empties[memory_int(*env, "empty_steps", i)];
    }
    INFO(id);
    const auto check = [&](const std::map<int, int>& counts, int low, int high) {
      CHECK(counts.begin()->first == low);
      CHECK(counts.rbegin()->first == high);
      const double expected = 4500.0 / (high - low + 1);
      double chi_squared = 0;
      for (int value = low; value <= high; ++value) {
        const auto found = counts.find(value);
        const double count = found == counts.end() ? 0 : found->second;
        chi_squared += (count - expected) * (count - expected) / expected;
      }
      const double freedom = high - low;
      CHECK(chi_squared < freedom + 5 * std::sqrt(2 * freedom) + 1);
    };
    check(targets, 0, ranges.cubes - 1);
    check(cues, ranges.cue_low, ranges.cue_high);
    check(empties, ranges.empty_low, ranges.empty_high);
  }
}

TEST_CASE("No two cubes ever overlap when they appear", "[remember_color]") {
  for (const std::string& id : test::implemented_ids()) {
    EnvOptions options;
    options.num_envs = 5000;
    const auto env = make_env(id, options);
    env->reset();
    double least = 1;
    for (int i = 0; i < options.num_envs; ++i) {
      for (int a = 0; a < cubes_of(*env); ++a) {
        for (int b = 0; b < a; ++b) {
          const Eigen::Vector3d offset = layout(*env, a, i) - layout(*env, b, i);
          least = std::min(least, std::max(std::abs(offset.x()), std::abs(offset.y())));
        }
        REQUIRE(layout(*env, a, i).z() == 0.02);
      }
    }
    INFO(id);
    CHECK(least >= 0.04 + 0.0007);  // 1 mm, at worst across a corner
  }
}

TEST_CASE("Success asks for phase, distance and stillness", "[remember_color]") {
  EnvOptions options;
  options.substeps = 0;  // the robot stays where the test puts it
  options.robot_init_qpos_noise = 0;
  options.pins = {{"cue_steps", {2}}, {"empty_steps", {2}}, {"target", {1}}};
  const auto env = make_env("RememberColor3-VLA-v0", options);
  env->reset();
  const State& state = env->state();
  const Eigen::Vector3d tcp = Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(0));
  const auto result = [&](double distance, double speed) {
    const Eigen::Vector3d pos = tcp + Eigen::Vector3d(0, 0, distance);
    std::copy_n(pos.data(), 3, state.prop_pos_of(0, 1));
    state.qvel.row(0)[3] = speed;
    test::step(*env, Policy::kZero);
    state.qvel.row(0)[3] = 0;
    return env->success()[0] != 0;
  };
  for (int t = 1; t < 4; ++t) {
    test::step(*env, Policy::kZero);
    CHECK(env->success()[0] == 0);
  }
  test::step(*env, Policy::kZero);  // t = 4: all cubes appear
  CHECK(env->success()[0] == 0);
  CHECK(result(0.03, 0));
  CHECK(result(0.05 - 1e-12, 0));
  CHECK_FALSE(result(0.05 + 1e-9, 0));
  CHECK(*row<std::uint8_t>(env->output("is_robot_static"), 0) == 1);
  CHECK(*row<std::uint8_t>(env->output("is_obj_placed"), 0) == 0);
  CHECK(result(0.03, 0.2));
  CHECK_FALSE(result(0.03, 0.2001));
  CHECK(*row<std::uint8_t>(env->output("is_obj_placed"), 0) == 1);
  CHECK(*row<std::uint8_t>(env->output("is_robot_static"), 0) == 0);
  CHECK(result(0.0, 0));  // on again: it is not latched
  CHECK(*row<std::uint8_t>(env->output("success_once"), 0) == 1);
  CHECK(env->terminated()[0] == 0);
}

TEST_CASE("Touching the cue before the cubes appear is no success", "[remember_color]") {
  EnvOptions options;
  options.pins = {
      {"cue_steps", {100}}, {"empty_steps", {50}}, {"robot_noise", {0, 0, 0, 0, 0, 0, 0}}};
  const auto env = make_env("RememberColor3-Long-VLA-v0", options);
  env->reset();
  const State& state = env->state();
  int placed = 0;
  for (int i = 0; i < 60; ++i) {
    const Eigen::Vector3d goal(0, 0, 0.055);
    const Eigen::Vector3d way = (goal - Eigen::Map<Eigen::Vector3d>(state.tcp_pos.row(0))) * 10;
    std::vector<float> action(7);
    for (std::size_t k = 0; k < 3; ++k) {
      action[k] = static_cast<float>(std::clamp(way[static_cast<Eigen::Index>(k)], -1.0, 1.0));
    }
    env->step(action);
    placed += *row<std::uint8_t>(env->output("is_obj_placed"), 0);
    CHECK(env->success()[0] == 0);
    if (env->state().elapsed[0] > 55) CHECK(env->reward()[0] > 0.5F);  // the bonus is not gated
  }
  CHECK(placed > 20);
}

TEST_CASE("State observations have the published lengths", "[remember_color]") {
  for (const auto& [id, length] : std::map<std::string, int>{{"RememberColor3-VLA-v0", 35},
                                                             {"RememberColor5-VLA-v0", 41},
                                                             {"RememberColor9-VLA-v0", 53}}) {
    CHECK(make_env(id)->state_dim() == length);
  }
}

TEST_CASE("A cube that was pushed is where it was pushed to", "[remember_color]") {
  EnvOptions options;
  options.pins = {{"cue_steps", {1}}, {"empty_steps", {1}}};
  const auto env = make_env("RememberColor5-VLA-v0", options);
  env->reset();
  for (int i = 0; i < 15; ++i) test::step(*env, Policy::kOracle);
  for (int i = 0; i < 9; ++i) env->step(std::vector<float>{0.5F, 0, -0.5F, 0, 0, 0, -0.6F});
  const int target = memory_int(*env, "target");
  CHECK((cube(*env, target) - layout(*env, target)).norm() > 0.003);
  CHECK(env->observation()[static_cast<std::size_t>(26 + 3 * target)] ==
        static_cast<float>(cube(*env, target).x()));
  // An episode later everything stands upright again.
  test::step(*env, Policy::kZero);
  test::step(*env, Policy::kZero);
  for (int i = 0; i < 6; ++i) test::step(*env, Policy::kZero);
  for (int key = 0; key < 5; ++key) CHECK(cube(*env, key) == layout(*env, key));
}

}  // namespace
}  // namespace engram
