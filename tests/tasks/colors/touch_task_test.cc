// The RL tasks of BunchOfColors, SeqOfColors and ChainOfColors in their environments.
#include "tasks/colors/touch_task.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "tests/env_helpers.h"
#include "tests/tasks/colors/touch_ids.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/rl_episodes.h"
#include "tests/tasks/spectator.h"

namespace engram {
namespace {

using test::make_env;
using test::Point;
using test::row;
using test::step_at;
using test::touch_colors::is_bunch;
using test::touch_colors::is_chain;
using test::touch_colors::kFamilies;
using test::touch_colors::start_of;
using test::touch_colors::three;

const Point kFarAway(-0.1, 0, 0.4);

Point cube(const Batch& env, int color, int index = 0) {
  return Point(env.state().prop_pos_of(index, color));
}
Eigen::Vector2d slot(const Batch& env, int color, int index = 0) {
  return Eigen::Map<const Eigen::Vector2d>(row<double>(env.memory().find("positions"), index) +
                                           2 * color);
}
bool shown(const Batch& env, int color) {
  return env.state().status_of(0, color) != PropStatus::kHidden;
}
bool touched(const Batch& env, int color) {
  return row<std::uint8_t>(env.memory().find("touched"), 0)[color] != 0;
}

// An environment without physics whose cue shows colours 4, 1 and 7.
std::unique_ptr<Batch> still_env(const std::string& id, BatchOptions options = {}) {
  options.substeps = 0;
  options.reward_mode = RewardMode::kDense;
  options.auto_reset = AutoReset::kOff;
  options.pins = {{"sequence", {4, 1, 7}}};
  auto env = make_env(id, options);
  env->reset();
  return env;
}

// The same in the first step of its action phase.
std::unique_ptr<Batch> acting(const std::string& id, const BatchOptions& options = {}) {
  auto env = still_env(id, options);
  while (env->state().elapsed[0] < start_of(id, 3)) step_at(*env, kFarAway);
  return env;
}

void touch(Batch& env, int color) {
  step_at(env, cube(env, color) + Point(0, 0, 0.035));
  if (env.state().finished[0] == 0) step_at(env, kFarAway);
}

TEST_CASE("RL colours: cue, empty and action phase have fixed lengths", "[color_recall][rl]") {
  const std::vector<int> cue = {4, 1, 7};
  for (const char* family : kFamilies) {
    const auto env = still_env(three(family));
    const int start = start_of(family, 3);
    CHECK(Queries(*env).cue_end(0) == start - 5);
    for (int t = 0; t <= start + 5; ++t) {
      INFO(family << ", elapsed " << t);
      for (int color = 0; color < 9; ++color) {
        const auto item = std::find(cue.begin(), cue.end(), color) - cue.begin();
        const bool in_cue = t < start - 5 && (is_bunch(family) ? item < 3 : item == t / 5);
        CHECK(shown(*env, color) == (in_cue || t >= start));
        const Eigen::Vector2d at = slot(*env, color);
        if (t >= start) {
          CHECK(cube(*env, color) == Point(at.x(), at.y(), 0.02));
        } else if (!in_cue) {
          const Point hidden = is_bunch(family) ? Point(0, 0, 1000) : Point(at.x(), at.y(), 1000);
          CHECK(cube(*env, color) == hidden);
        } else if (!is_bunch(family)) {
          CHECK(cube(*env, color) == Point(0, 0, 0.02));
        } else {
          const double angle = std::numbers::pi * (color - 4) / 9;
          const Point place(0.22 * std::cos(angle), 0.22 * std::sin(angle) - 0.015 * (color - 4),
                            0.02);
          CHECK((cube(*env, color) - place).norm() < 1e-9);
        }
      }
      step_at(*env, kFarAway);
    }
  }
}

TEST_CASE("RL colours: cubes are placed once, when they appear", "[color_recall][rl]") {
  const std::string id = three("SeqOfColors");
  const auto env = still_env(id);
  for (int t = 1; t < start_of(id, 3) + 3; ++t) {
    env->state().prop_pos_of(0, 2)[0] += 0.03;
    step_at(*env, kFarAway);
    const bool placed = env->state().elapsed[0] == start_of(id, 3);
    INFO("elapsed " << env->state().elapsed[0]);
    CHECK((cube(*env, 2) == Point(slot(*env, 2).x(), slot(*env, 2).y(), 0.02)) == placed);
  }
}

TEST_CASE("RL colours: places are the nine slots of the narrow arc, jittered and shuffled",
          "[color_recall][rl]") {
  BatchOptions options;
  options.num_envs = 1000;
  const auto env = make_env("ChainOfColors7-v0", options);
  env->reset();
  Eigen::Vector2d deviation = Eigen::Vector2d::Zero();
  std::array<int, 9> of_red{};
  for (int i = 0; i < options.num_envs; ++i) {
    std::set<int> taken;
    for (int color = 0; color < 9; ++color) {
      int nearest = 0;
      Eigen::Vector2d offset(1, 1);
      for (int k = 0; k < 9; ++k) {
        const double angle = std::numbers::pi * (k - 4) / 9;
        const Eigen::Vector2d nominal(0.3 * std::cos(angle) - 0.25,
                                      0.3 * std::sin(angle) - 0.025 * (k - 4));
        if ((slot(*env, color, i) - nominal).norm() >= offset.norm()) continue;
        offset = slot(*env, color, i) - nominal;
        nearest = k;
      }
      taken.insert(nearest);
      deviation += offset.cwiseProduct(offset);
      if (color == 0) ++of_red[static_cast<std::size_t>(nearest)];
      for (int other = 0; other < color; ++other) {
        CHECK((slot(*env, color, i) - slot(*env, other, i)).norm() >= 0.0599);
      }
    }
    CHECK(taken.size() >= 8);  // jitter may lead nearer to a neighbour
  }
  for (int axis = 0; axis < 2; ++axis) {
    CHECK(std::sqrt(deviation[axis] / (9 * options.num_envs)) == Approx(0.01).epsilon(0.05));
  }
  for (const int count : of_red) CHECK(std::abs(count - 111) < 55);
}

TEST_CASE("RL colours: a touch asks for 2 cm, stillness and the phase", "[color_recall][rl]") {
  for (const char* family : kFamilies) {
    INFO(family);
    const std::string id = three(family);
    const auto env = acting(id);
    const Point point = cube(*env, 4) + Point(0, 0, 0.025);
    step_at(*env, point + Point(0, 0, 0.02 + 1e-6));
    CHECK_FALSE(touched(*env, 4));
    test::pose_tool(*env, point);
    env->state().qvel.row(0)[2] = 0.21;
    test::step(*env, Policy::kZero);
    CHECK_FALSE(touched(*env, 4));
    step_at(*env, point + Point(0, 0, 0.02 - 1e-6));
    CHECK(touched(*env, 4));
    step_at(*env, kFarAway);
    CHECK(touched(*env, 4));

    // At the very place, too early.
    const auto early = still_env(id);
    const Point place(slot(*early, 4).x(), slot(*early, 4).y(), 0.045);
    while (early->state().elapsed[0] < start_of(id, 3) - 1) {
      step_at(*early, place);
      CHECK_FALSE(touched(*early, 4));
    }
    step_at(*early, place);
    CHECK(touched(*early, 4));
  }
  BatchOptions wide;
  wide.task_options = {{"touch_radius", 0.05}};
  const auto env = acting("BunchOfColors3-v0", wide);
  step_at(*env, cube(*env, 4) + Point(0, 0, 0.07));
  CHECK(touched(*env, 4));
}

TEST_CASE("RL colours: the last touch succeeds and ends the episode", "[color_recall][rl]") {
  struct Row {
    std::vector<int> touches;
    bool set, order;  // whether that is right for Bunch and Seq, and for Chain
  };
  const Row rows[] = {{{4, 1, 7}, true, true},      {{7, 4, 1}, true, false},
                      {{4, 4, 1, 7}, true, true},   {{4, 1, 3}, false, false},
                      {{4, 3, 1, 7}, false, false}, {{3, 4, 1, 7}, false, false},
                      {{4, 1}, false, false}};
  for (const char* family : kFamilies) {
    for (const auto& [touches, set, order] : rows) {
      for (const bool ends : {true, false}) {
        INFO(family << ", row with " << touches.size() << " touches, ends " << ends);
        BatchOptions options;
        options.terminate_on_success = ends;
        const auto env = acting(three(family), options);
        for (const int color : touches) {
          CHECK(env->success()[0] == 0);
          touch(*env, color);
        }
        const bool right = is_chain(family) ? order : set;
        CHECK(env->state().finished[0] == (right && ends ? 1 : 0));
        CHECK(env->success()[0] == (right ? 1 : 0));
        if (!right) continue;
        CHECK(env->terminated()[0] == (ends ? 1 : 0));
        CHECK(env->reward()[0] == 100);
        if (ends) continue;
        // A wrong touch spoils it.
        touch(*env, 5);
        CHECK(env->success()[0] == 0);
        CHECK(env->reward()[0] < 100);
      }
    }
  }
}

TEST_CASE("RL colours: goals are the lowest colour, in Chain the cue's order",
          "[color_recall][rl]") {
  struct Row {
    std::vector<int> touches;
    int set, chain;  // the next target, -1: none
  };
  const Row rows[] = {{{}, 1, 4},        {{4}, 1, 1},          {{7}, 1, 4},
                      {{4, 7}, 1, 1},    {{1, 4, 7}, -1, 4},   {{4, 1, 7}, -1, 7},
                      {{4, 1, 3}, 7, 7}, {{4, 1, 7, 3}, -1, 4}};
  for (const char* family : kFamilies) {
    for (const auto& [touches, set, chain] : rows) {
      BatchOptions options;
      options.terminate_on_success = false;
      const auto env = still_env(three(family), options);
      const float* goal = row<float>(env->output("obj_to_goal_pos"), 0);
      while (env->state().elapsed[0] < start_of(family, 3)) {
        for (int i = 0; i < 3; ++i) CHECK(goal[i] == 0);
        step_at(*env, kFarAway);
      }
      for (const int color : touches) touch(*env, color);
      step_at(*env, kFarAway);
      const int next = is_chain(family) ? chain : set;
      INFO(family << ", " << touches.size() << " touches, next " << next);
      const Point expected =
          next < 0 ? Point(0, 0, 0) : Point(cube(*env, next) + Point(0, 0, 0.025) - kFarAway);
      for (int i = 0; i < 3; ++i) CHECK(goal[i] == Approx(expected[i]).margin(1e-6));
      for (int color = 0; color < 9; ++color) {
        const auto place = static_cast<std::size_t>(18 + 7 + 3 + 3 + 6 * color);
        CHECK(env->observation()[place + 3] == (touched(*env, color) ? 1 : 0));
        CHECK(env->observation()[place + 4] == (color == 4 || color == 1 || color == 7 ? 1 : 0));
        CHECK(env->observation()[place + 5] == (color == next ? 1 : 0));
      }
    }
  }
}

TEST_CASE("RL colours have the published sizes", "[color_recall][rl]") {
  const std::map<int, int> widths = {{3, 85}, {5, 87}, {7, 89}};
  for (const char* family : kFamilies) {
    CHECK(test::rl_ids(family).size() == 3);
    for (const auto& [length, width] : widths) {
      const std::string id = family + std::to_string(length) + "-v0";
      INFO(id);
      const auto env = make_env(id);
      const TaskInfo& info = env->info();
      CHECK(env->state_dim() == width);
      test::check_rl_facts(id, 120, is_chain(id) ? "Sequential" : "Capacity");
      CHECK(info.oracle_dim == length);
      CHECK(info.success_reward == 100);
      CHECK(info.task_cue_dim == 0);
      CHECK(info.instruction.find("button") == std::string::npos);
      CHECK(info.candidates ==
            make_task(family + std::to_string(length) + "-VLA-v0")->info().candidates);
      std::set<std::string> keys;
      for (const Field& field : info.reward_terms) keys.insert(field.name);
      CHECK(keys == std::set<std::string>{
                        "reaching_reward", "wrong_touches", "is_robot_static", "touched_cubes",
                        is_chain(id) ? "correct_touches_in_order" : "correct_touches",
                        "sequence_cubes_mask", "all_seq_touched", "no_extra_touched"});
      CHECK(env->physics_model().props().size() == 9);
      for (const char* none : {"button_pressed", "strong_cube_displacement", "xy_dist_to_button"}) {
        CHECK(env->outputs().find(none).field == nullptr);
      }
    }
  }
}

TEST_CASE("RL colours: the oracle solves them in both modes and moves no cube",
          "[color_recall][rl][oracle]") {
  constexpr int kEpisodes = 40;
  for (const char* family : kFamilies) {
    for (const std::string& id : test::rl_ids(family)) {
      for (const ControlMode mode : {ControlMode::kPdJointDeltaPos, ControlMode::kPdEeDeltaPose}) {
        INFO(id << ", " << name_of(mode));
        BatchOptions options;
        options.num_envs = kEpisodes;
        options.threads = 2;
        options.seed = 1000;
        options.control_mode = mode;
        options.auto_reset = AutoReset::kOff;
        const auto env = make_env(id, options);
        env->reset();
        for (int t = 0; t < env->info().horizon; ++t) test::step(*env, Policy::kOracle);
        int solved = 0;
        double farthest = 0;
        for (int i = 0; i < kEpisodes; ++i) {
          solved += *row<std::uint8_t>(env->output("success_once"), i);
          for (int color = 0; color < 9; ++color) {
            const Eigen::Vector2d at = cube(*env, color, i).head<2>();
            farthest = std::max(farthest, (at - slot(*env, color, i)).norm());
          }
        }
        CHECK(solved >= 38);
        CHECK(farthest < 0.001);
      }
    }
  }
}

TEST_CASE("RL colours: the oracle waits low with open fingers, wherever the cubes will be",
          "[color_recall][rl][oracle]") {
  for (const char* family : kFamilies) {
    std::vector<std::vector<float>> waiting;
    for (const double first : {4, 2}) {
      BatchOptions options;
      options.pins = {{"sequence", {first, 1, 7}}};
      const auto env = make_env(three(family), options);
      env->reset();
      auto& actions = waiting.emplace_back();
      while (env->success()[0] == 0 && env->state().elapsed[0] < 119) {
        const std::vector<float> action = test::act(*env, Policy::kOracle);
        CHECK(action.back() == 1);
        const bool waits = env->state().elapsed[0] < start_of(family, 3);
        if (waits) actions.insert(actions.end(), action.begin(), action.end());
        env->step(action);
        if (!waits || env->state().elapsed[0] < start_of(family, 3)) continue;
        CHECK(env->state().tcp_pos.row(0)[2] < (is_bunch(family) ? 0.2 : 0.11));
        CHECK(env->state().tcp_pos.row(0)[2] > 0.07);
      }
      CHECK(env->success()[0] != 0);
    }
    CHECK(waiting[0] == waiting[1]);
  }
}

TEST_CASE("RL colours: constants can be changed, but not what has no effect",
          "[variants][color_recall][rl]") {
  for (const char* family : kFamilies) {
    INFO(family);
    const std::string id = three(family);
    const char* cue = is_bunch(id) ? "CUE_PHASE_STEPS" : "CUE_STEP_DURATION";
    MakeOptions options;
    options.num_envs = 40;
    options.constants = {{"SEQUENCE_LENGTH", 2},
                         {"COLORS", 6},
                         {cue, ConstantList{3, 4}},
                         {"EMPTY_PHASE_STEPS", 9},
                         {"CUBE_HALFSIZE", 0.025}};
    const auto env = make_env(id, options);
    env->reset();
    std::set<int> ends;
    for (int i = 0; i < 40; ++i) ends.insert(Queries(*env).cue_end(i));
    CHECK(ends == (is_bunch(id) ? std::set<int>{3, 4} : std::set<int>{6, 8}));
    CHECK(env->info().candidates == (is_chain(id) ? 30 : 15));
    CHECK(env->info().options[0].value == 0.025);  // touch_radius
    CHECK(env->state_dim() == 25 + 3 + 2 + 6 * 6);

    const auto published = published_constants(make_task(id)->info().constants);
    const auto value = [&](const char* name) {
      const auto found =
          std::ranges::find(published, name, [](const auto& entry) { return entry.first; });
      return found == published.end() ? "none" : in_words(found->second);
    };
    CHECK(value(is_bunch(id) ? "TIME_OFFSET" : "STEP_DURATION") == "5");
    CHECK(value("EMPTY_DURATION") == "5");
    CHECK(value(cue) == "none");
    CHECK(value("GOAL_THRESH") == "0.05");
    CHECK_THROWS_WITH(make_task(id, {{"GOAL_THRESH", 0.03}}),
                      Catch::Contains("nobody can change it"));
    CHECK_THROWS_WITH(make_task(id, {{"CUBE_HALFSIZE", 0.035}}),
                      Catch::Contains("larger cubes do not stand apart from one another"));
    CHECK_THROWS_WITH(make_task(id, {{cue, 200}}), Catch::Contains("120"));
  }
}

}  // namespace
}  // namespace engram
