// SeqOfColors, ChainOfColors and BunchOfColors with other constants: what follows from each, and
// sets that contradict themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/variants/constant_text.h"

namespace engram {
namespace {

using Catch::Contains, Eigen::Vector3d, test::make_reset, test::row, test::step_at;

constexpr const char* kSeq = "SeqOfColors3-VLA-v0";
constexpr const char* kChain = "ChainOfColors3-VLA-v0";
constexpr const char* kBunch = "BunchOfColors3-VLA-v0";
constexpr const char* kAll[] = {kSeq, kChain, kBunch};
const Vector3d kFarAway(-0.1, 0, 0.4);

// The cue's constant and its draw.
const char* cue_constant(const char* id) {
  return id == kBunch ? "CUE_PHASE_STEPS" : "CUE_STEP_DURATION";
}
const char* cue_draw(const char* id) { return id == kBunch ? "cue_steps" : "cue_step_duration"; }

// Without physics, in the first step of the action phase; the cue shows the first colours.
std::unique_ptr<Batch> acting(const char* id, const ConstantTable& constants, int length = 3) {
  MakeOptions options;
  options.substeps = 0;
  options.reward_mode = RewardMode::kDense;
  std::vector<double> sequence;
  for (int i = 0; i < length; ++i) sequence.push_back(i);
  options.pins = {{"sequence", sequence}, {cue_draw(id), {1}}, {"empty_steps", {1}}};
  auto batch = make_reset(id, constants, options);
  const int start = Queries(*batch).cue_end(0) + 1;
  for (int t = 0; t < start; ++t) step_at(*batch, kFarAway);
  return batch;
}

Vector3d cube(const Batch& batch, int color) {
  return Eigen::Map<Vector3d>(batch.state().prop_pos_of(0, color));
}
bool shown(const Batch& batch, int color) {
  return batch.state().status_of(0, color) != PropStatus::kHidden;
}
bool touched(const Batch& batch, int color) {
  return row<std::uint8_t>(test::memory_of(batch).find("touched"), 0)[color] != 0;
}
void press_button(Batch& batch) {
  const double* at = row<double>(test::memory_of(batch).find("center_button_xy"), 0);
  for (const double height : {0.1, 0.08, 0.09, 0.17}) step_at(batch, {at[0], at[1], height});
}

TEST_CASE("Candidates follow SEQUENCE_LENGTH and COLORS", "[variants][color_recall]") {
  struct Row {
    const char* id;
    int length, colors, candidates;
  };
  const Row rows[] = {{kSeq, 3, 5, 10},  {kBunch, 3, 5, 10}, {kChain, 3, 5, 60},
                      {kSeq, 1, 9, 9},   {kBunch, 8, 9, 9},  {kChain, 9, 9, 362'880},
                      {kChain, 2, 2, 2}, {kBunch, 2, 4, 6},  {kSeq, 4, 6, 15}};
  for (const auto& [id, length, colors, candidates] : rows) {
    INFO(id << " " << length << " of " << colors);
    const auto task = make_task(id, {{"SEQUENCE_LENGTH", length}, {"COLORS", colors}});
    const TaskInfo& info = task->info();
    CHECK(info.candidates == candidates);
    CHECK(info.chance() == Approx(1.0 / candidates));
    CHECK(info.oracle_dim == length);
    CHECK(info.random_variables[0].width == length);
    CHECK(info.random_variables[0].high == colors - 1);
    CHECK(info.random_variables[1].width == 2 * colors);
    CHECK(task->scene().props.size() == static_cast<std::size_t>(colors) + 2);
    CHECK(test::constant_text(task->info(), "COLORS") == std::to_string(colors));
    CHECK(test::constant_text(task->info(), "SEQUENCE_LENGTH") == std::to_string(length));
    // Position and three flags of every cube, after goal, cue and button.
    int width = 0;
    for (const auto& field : info.state_fields) width += field.width;
    CHECK(width == 3 + length + 2 + 1 + 6 * colors);
  }
}

TEST_CASE("All colours of a smaller set are drawn, in all places", "[variants][color_recall]") {
  for (const char* id : kAll) {
    MakeOptions options;
    options.num_envs = 200;
    const auto batch = make_reset(id, {{"COLORS", 5}, {"SEQUENCE_LENGTH", 2}}, options);
    std::set<int> seen;
    for (int i = 0; i < 200; ++i) {
      const std::int32_t* sequence = row<std::int32_t>(test::memory_of(*batch).find("sequence"), i);
      CHECK(sequence[0] != sequence[1]);
      seen.insert(sequence, sequence + 2);
      const double* places = row<double>(test::memory_of(*batch).find("positions"), i);
      for (int a = 0; a < 5; ++a) {
        for (int b = 0; b < a; ++b) {
          const double gap = std::max(std::abs(places[2 * a] - places[2 * b]),
                                      std::abs(places[2 * a + 1] - places[2 * b + 1]));
          CHECK(gap > 0.041);
        }
      }
    }
    CHECK(seen == std::set<int>{0, 1, 2, 3, 4});
  }
}

TEST_CASE("Success needs all the colours, then the button", "[variants][color_recall]") {
  for (const char* id : kAll) {
    for (const int length : {1, 5}) {
      INFO(id << " " << length);
      const auto batch = acting(id, {{"SEQUENCE_LENGTH", length}, {"COLORS", 6}}, length);
      for (int color = 0; color < length; ++color) {
        press_button(*batch);
        CHECK(batch->outputs().success[0] == 0);
        step_at(*batch, cube(*batch, color) + Vector3d(0, 0, 0.035));
        // A right touch is worth its share of 90.
        const double share = 90.0 * (color + 1) / length;
        CHECK(batch->outputs().reward[0] >= share);
        CHECK(batch->outputs().reward[0] <= share + 1.5);
      }
      press_button(*batch);
      CHECK(batch->outputs().success[0] == 1);
      CHECK(batch->outputs().reward[0] == 400);
    }
  }
}

TEST_CASE("Cue and empty phase are as long as they were made", "[variants][color_recall]") {
  for (const char* id : kAll) {
    INFO(id);
    MakeOptions options;
    options.num_envs = 80;
    const auto batch = make_reset(id,
                                  {{cue_constant(id), ConstantList{7, 9}},
                                   {"EMPTY_PHASE_STEPS", ConstantList{20, 22}},
                                   {"SEQUENCE_LENGTH", 4},
                                   {"max_episode_steps", 200}},
                                  options);
    const int items = id == kBunch ? 1 : 4;
    std::set<int> cues, gaps;
    for (int i = 0; i < 80; ++i) {
      cues.insert(Queries(*batch).cue_end(i));
      gaps.insert(*row<std::int32_t>(test::memory_of(*batch).find("empty_steps"), i));
    }
    CHECK(cues == std::set<int>{7 * items, 8 * items, 9 * items});
    CHECK(gaps == std::set<int>{20, 21, 22});
    CHECK(batch->info().horizon == 200);
    // Resets may narrow them.
    const ConstantTable easy = {{cue_constant(id), 7}, {"EMPTY_PHASE_STEPS", 21}};
    batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &easy});
    for (int i = 0; i < 80; ++i) {
      CHECK(Queries(*batch).cue_end(i) == 7 * items);
      CHECK(*row<std::int32_t>(test::memory_of(*batch).find("empty_steps"), i) == 21);
    }
  }
  // Every item of a cue is shown for the same time.
  MakeOptions options;
  options.substeps = 0;
  options.pins = {{"sequence", {3, 1, 0, 4}}, {"cue_step_duration", {7}}};
  const auto batch =
      make_reset(kChain, {{"SEQUENCE_LENGTH", 4}, {"CUE_STEP_DURATION", 7}}, options);
  const int expected[] = {3, 1, 0, 4};
  for (int t = 0; t < 28; ++t) {
    for (int color = 0; color < 9; ++color)
      CHECK(shown(*batch, color) == (color == expected[t / 7]));
    step_at(*batch, kFarAway);
  }
  for (int color = 0; color < 9; ++color) CHECK_FALSE(shown(*batch, color));
}

TEST_CASE("A touch is as near as GOAL_THRESH to a point over the cube",
          "[variants][color_recall]") {
  for (const char* id : kAll) {
    for (const double size : {0.015, 0.025}) {
      INFO(id << " " << size);
      const auto batch = acting(id, {{"GOAL_THRESH", 0.03}, {"CUBE_HALFSIZE", size}});
      const Vector3d point = cube(*batch, 0) + Vector3d(0, 0, size + 0.005);
      step_at(*batch, point + Vector3d(0, 0, 0.03 + 1e-6));
      CHECK_FALSE(touched(*batch, 0));
      step_at(*batch, point + Vector3d(0, 0, 0.03 - 1e-6));
      CHECK(touched(*batch, 0));
      CHECK(test::constant_text(batch->info(), "GOAL_THRESH") == "0.03");
    }
  }
  // The rule's option says how near, if it is given: the constant is what it is otherwise.
  const auto task = make_task(kSeq, {{"GOAL_THRESH", 0.03}});
  CHECK(task->info().options[0].value == 0.03);
}

TEST_CASE("Cubes are as large and heavy as CUBE_HALFSIZE says", "[variants][color_recall]") {
  for (const char* id : kAll) {
    for (const double size : {0.01, 0.025}) {
      INFO(id << " " << size);
      const auto batch = acting(id, {{"CUBE_HALFSIZE", size}});
      CHECK(batch->physics_model().props()[0].mass == Approx(1000 * 8 * size * size * size));
      for (int color = 0; color < 9; ++color) CHECK(cube(*batch, color).z() == size);
      CHECK(test::size_in(make_task(id, {{"CUBE_HALFSIZE", size}})->document(), "cube_0") == size);
    }
  }
}

TEST_CASE("Penalties on actions lower the reward", "[variants][color_recall]") {
  const auto usual = acting(kSeq, {});
  const auto costly = acting(kSeq, {{"ACTION_L2_COEF", 2.0}});
  for (Batch* batch : {usual.get(), costly.get()}) {
    test::pose_tool(*batch, kFarAway);
    batch->step(std::vector<float>(7, 1.0F));
  }
  CHECK(usual->outputs().reward[0] - costly->outputs().reward[0] == Approx(2).margin(1e-3));
}

TEST_CASE("Sets of colours that contradict themselves are refused", "[variants][color_recall]") {
  struct Refused {
    const char* id;
    ConstantTable constants;
    const char* says;
  };
  const std::vector<Refused> refused = {
      {kSeq,
       {{"COLORS", 3}},
       "3 given, at most 2 of 3 COLORS allowed, or there is one answer only"},
      {kBunch, {{"SEQUENCE_LENGTH", 9}}, "at most 8 of 9 COLORS"},
      {kChain, {{"SEQUENCE_LENGTH", 5}, {"COLORS", 4}}, "5 given, at most 4 of 4 COLORS allowed"},
      {kBunch, {{"CUBE_HALFSIZE", 0.027}}, "constant 'CUBE_HALFSIZE': 0.027 given, at most 0.0"},
      {kBunch, {{"CUBE_HALFSIZE", 0.03}}, "allowed with COLORS 9: larger cubes do not stand apart"},
      {kSeq, {{"CUBE_HALFSIZE", 0.035}, {"COLORS", 2}, {"SEQUENCE_LENGTH", 1}}, "the button"},
      {kBunch,
       {{"CUE_PHASE_STEPS", 300}, {"EMPTY_PHASE_STEPS", 90}},
       "CUE_PHASE_STEPS 300 + EMPTY_PHASE_STEPS 90 + 39 to act = 429 control steps"},
      {kSeq,
       {{"CUE_STEP_DURATION", 120}},
       "SEQUENCE_LENGTH x CUE_STEP_DURATION 360 + EMPTY_PHASE_STEPS 5 + 39 to act = 404"},
      {kSeq, {{"CUE_PHASE_STEPS", 5}}, "no constant named 'CUE_PHASE_STEPS'"},
      {kBunch, {{"COLORS", 10}}, "a whole number from 2 to 9"},
  };
  for (const Refused& row : refused) {
    INFO(row.id << ": " << row.says);
    CHECK_THROWS_WITH(make_task(row.id, row.constants), Contains(row.says));
  }
}

TEST_CASE("The size that a refusal allows is allowed, and no larger one",
          "[variants][color_recall]") {
  int refused = 0;
  for (const char* id : kAll) {
    for (const int colors : {2, 3, 5, 9}) {
      const auto with_size = [&](double size) {
        return ConstantTable{{"CUBE_HALFSIZE", size}, {"COLORS", colors}, {"SEQUENCE_LENGTH", 1}};
      };
      INFO(id << ", " << colors << " colours");
      std::string message;
      try {
        (void)make_task(id, with_size(0.035));
      } catch (const Error& error) {
        message = error.what();
      }
      if (message.empty()) continue;  // all sizes fit
      ++refused;
      REQUIRE(message.find("0.035 given, at most ") != std::string::npos);
      const double most = std::stod(message.substr(message.find("at most ") + 8));
      CHECK(most >= 0.02);
      CHECK_NOTHROW(make_task(id, with_size(most)));
      CHECK_THROWS_WITH(make_task(id, with_size(most + 0.0005)), Contains("at most"));
    }
  }
  CHECK(refused == 3);  // nine cubes of a bunch, and two with a button between them
}

}  // namespace
}  // namespace engram
