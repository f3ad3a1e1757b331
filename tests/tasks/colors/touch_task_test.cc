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

using test::make_env, test::make_running, test::Point, test::row, test::step_at,
    test::touch_colors::is_bunch, test::touch_colors::is_chain, test::touch_colors::kFamilies,
    test::touch_colors::start_of, test::touch_colors::three;

const Point kFarAway(-0.1, 0, 0.4);

Point cube(const Batch& batch, int color, int index = 0) {
  return Point(batch.state().prop_pos_of(index, color));
}
Eigen::Vector2d slot(const Batch& batch, int color, int index = 0) {
  return Eigen::Map<const Eigen::Vector2d>(
      row<double>(test::memory_of(batch).find("positions"), index) + 2 * color);
}
bool shown(const Batch& batch, int color) {
  return batch.state().status_of(0, color) != PropStatus::kHidden;
}
bool touched(const Batch& batch, int color) {
  return row<std::uint8_t>(test::memory_of(batch).find("touched"), 0)[color] != 0;
}

// An environment without physics whose cue shows colours 4, 1 and 7.
std::unique_ptr<Batch> still_env(const std::string& id, BatchOptions options = {}) {
  options.substeps = 0;
  options.reward_mode = RewardMode::kDense;
  options.auto_reset = AutoReset::kOff;
  options.pins = {{"sequence", {4, 1, 7}}};
  return make_running(id, options);
}

// A batch in the first step of its action phase.
std::unique_ptr<Batch> acting(const std::string& id, const BatchOptions& options = {}) {
  auto batch = still_env(id, options);
  while (batch->state().elapsed[0] < start_of(id, 3)) step_at(*batch, kFarAway);
  return batch;
}

void touch(Batch& batch, int color) {
  step_at(batch, cube(batch, color) + Point(0, 0, 0.035));
  if (batch.state().finished[0] == 0) step_at(batch, kFarAway);
}

TEST_CASE("RL colours: cue, empty and action phase have fixed lengths", "[color_recall][rl]") {
  const std::vector<int> cue = {4, 1, 7};
  for (const char* family : kFamilies) {
    const auto batch = still_env(three(family));
    const int start = start_of(family, 3);
    CHECK(Queries(*batch).cue_end(0) == start - 5);
    for (int t = 0; t <= start + 5; ++t) {
      INFO(family << ", elapsed " << t);
      for (int color = 0; color < 9; ++color) {
        const auto item = std::find(cue.begin(), cue.end(), color) - cue.begin();
        const bool in_cue = t < start - 5 && (is_bunch(family) ? item < 3 : item == t / 5);
        CHECK(shown(*batch, color) == (in_cue || t >= start));
        const Eigen::Vector2d at = slot(*batch, color);
        if (t >= start) {
          CHECK(cube(*batch, color) == Point(at.x(), at.y(), 0.02));
        } else if (!in_cue) {
          const Point hidden = is_bunch(family) ? Point(0, 0, 1000) : Point(at.x(), at.y(), 1000);
          CHECK(cube(*batch, color) == hidden);
        } else if (!is_bunch(family)) {
          CHECK(cube(*batch, color) == Point(0, 0, 0.02));
        } else {
          const double angle = std::numbers::pi * (color - 4) / 9;
          const Point place(0.22 * std::cos(angle), 0.22 * std::sin(angle) - 0.015 * (color - 4),
                            0.02);
          CHECK((cube(*batch, color) - place).norm() < 1e-9);
        }
      }
      step_at(*batch, kFarAway);
    }
  }
}

TEST_CASE("RL colours: cubes are placed once, when they appear", "[color_recall][rl]") {
  const std::string id = three("SeqOfColors");
  const auto batch = still_env(id);
  for (int t = 1; t < start_of(id, 3) + 3; ++t) {
    batch->state().prop_pos_of(0, 2)[0] += 0.03;
    step_at(*batch, kFarAway);
    const bool placed = batch->state().elapsed[0] == start_of(id, 3);
    INFO("elapsed " << batch->state().elapsed[0]);
    CHECK((cube(*batch, 2) == Point(slot(*batch, 2).x(), slot(*batch, 2).y(), 0.02)) == placed);
  }
}

TEST_CASE("RL colours: places are the nine slots of the narrow arc, jittered and shuffled",
          "[color_recall][rl]") {
  const BatchOptions options{.num_envs = 1000};
  const auto batch = make_running("ChainOfColors7-v0", options);
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
        if ((slot(*batch, color, i) - nominal).norm() >= offset.norm()) continue;
        offset = slot(*batch, color, i) - nominal;
        nearest = k;
      }
      taken.insert(nearest);
      deviation += offset.cwiseProduct(offset);
      if (color == 0) ++of_red[static_cast<std::size_t>(nearest)];
      for (int other = 0; other < color; ++other) {
        CHECK((slot(*batch, color, i) - slot(*batch, other, i)).norm() >= 0.0599);
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
    const auto batch = acting(id);
    const Point point = cube(*batch, 4) + Point(0, 0, 0.025);
    step_at(*batch, point + Point(0, 0, 0.02 + 1e-6));
    CHECK_FALSE(touched(*batch, 4));
    test::pose_tool(*batch, point);
    batch->state().qvel.row(0)[2] = 0.21;
    test::step(*batch, Policy::kZero);
    CHECK_FALSE(touched(*batch, 4));
    step_at(*batch, point + Point(0, 0, 0.02 - 1e-6));
    CHECK(touched(*batch, 4));
    step_at(*batch, kFarAway);
    CHECK(touched(*batch, 4));

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
  const BatchOptions wide{.task_options = {{"touch_radius", 0.05}}};
  const auto batch = acting("BunchOfColors3-v0", wide);
  step_at(*batch, cube(*batch, 4) + Point(0, 0, 0.07));
  CHECK(touched(*batch, 4));
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
        const BatchOptions options{.terminate_on_success = ends};
        const auto batch = acting(three(family), options);
        for (const int color : touches) {
          CHECK(batch->outputs().success[0] == 0);
          touch(*batch, color);
        }
        const bool right = is_chain(family) ? order : set;
        CHECK(batch->state().finished[0] == (right && ends ? 1 : 0));
        CHECK(batch->outputs().success[0] == (right ? 1 : 0));
        if (!right) continue;
        CHECK(batch->outputs().terminated[0] == (ends ? 1 : 0));
        CHECK(batch->outputs().reward[0] == 100);
        if (ends) continue;
        // A wrong touch spoils it.
        touch(*batch, 5);
        CHECK(batch->outputs().success[0] == 0);
        CHECK(batch->outputs().reward[0] < 100);
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
      const BatchOptions options{.terminate_on_success = false};
      const auto batch = still_env(three(family), options);
      const float* goal = row<float>(batch->output("obj_to_goal_pos"), 0);
      while (batch->state().elapsed[0] < start_of(family, 3)) {
        for (int i = 0; i < 3; ++i) CHECK(goal[i] == 0);
        step_at(*batch, kFarAway);
      }
      for (const int color : touches) touch(*batch, color);
      step_at(*batch, kFarAway);
      const int next = is_chain(family) ? chain : set;
      INFO(family << ", " << touches.size() << " touches, next " << next);
      const Point expected =
          next < 0 ? Point(0, 0, 0) : Point(cube(*batch, next) + Point(0, 0, 0.025) - kFarAway);
      for (int i = 0; i < 3; ++i) CHECK(goal[i] == Approx(expected[i]).margin(1e-6));
      for (int color = 0; color < 9; ++color) {
        const auto place = static_cast<std::size_t>(18 + 7 + 3 + 3 + 6 * color);
        CHECK(batch->outputs().observation[place + 3] == (touched(*batch, color) ? 1 : 0));
        CHECK(batch->outputs().observation[place + 4] ==
              (color == 4 || color == 1 || color == 7 ? 1 : 0));
        CHECK(batch->outputs().observation[place + 5] == (color == next ? 1 : 0));
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
      const auto batch = make_env(id);
      const TaskInfo& info = batch->info();
      CHECK(batch->state_dim() == width);
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
      CHECK(batch->physics_model().props().size() == 9);
      for (const char* none : {"button_pressed", "strong_cube_displacement", "xy_dist_to_button"}) {
        CHECK(test::columns_of(*batch).find(none).field == nullptr);
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
        const auto batch = make_running(id, {.num_envs = kEpisodes,
                                             .seed = 1000,
                                             .threads = 2,
                                             .control_mode = mode,
                                             .auto_reset = AutoReset::kOff});
        for (int t = 0; t < batch->info().horizon; ++t) test::step(*batch, Policy::kOracle);
        int solved = 0;
        double farthest = 0;
        for (int i = 0; i < kEpisodes; ++i) {
          solved += *row<std::uint8_t>(batch->output("success_once"), i);
          for (int color = 0; color < 9; ++color) {
            const Eigen::Vector2d at = cube(*batch, color, i).head<2>();
            farthest = std::max(farthest, (at - slot(*batch, color, i)).norm());
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
      const auto batch = make_running(three(family), {.pins = {{"sequence", {first, 1, 7}}}});
      auto& actions = waiting.emplace_back();
      while (batch->outputs().success[0] == 0 && batch->state().elapsed[0] < 119) {
        const std::vector<float> action = test::act(*batch, Policy::kOracle);
        CHECK(action.back() == 1);
        const bool waits = batch->state().elapsed[0] < start_of(family, 3);
        if (waits) actions.insert(actions.end(), action.begin(), action.end());
        batch->step(action);
        if (!waits || batch->state().elapsed[0] < start_of(family, 3)) continue;
        CHECK(batch->state().tcp_pos.row(0)[2] < (is_bunch(family) ? 0.2 : 0.11));
        CHECK(batch->state().tcp_pos.row(0)[2] > 0.07);
      }
      CHECK(batch->outputs().success[0] != 0);
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
    const MakeOptions options{{.num_envs = 40},
                              {{"SEQUENCE_LENGTH", 2},
                               {"COLORS", 6},
                               {cue, ConstantList{3, 4}},
                               {"EMPTY_PHASE_STEPS", 9},
                               {"CUBE_HALFSIZE", 0.025}}};
    const auto batch = make_running(id, options);
    std::set<int> ends;
    for (int i = 0; i < 40; ++i) ends.insert(Queries(*batch).cue_end(i));
    CHECK(ends == (is_bunch(id) ? std::set<int>{3, 4} : std::set<int>{6, 8}));
    CHECK(batch->info().candidates == (is_chain(id) ? 30 : 15));
    CHECK(batch->info().options[0].value == 0.025);  // touch_radius
    CHECK(batch->state_dim() == 25 + 3 + 2 + 6 * 6);

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
