// TraceShape and TraceShapeSeq with other constants: what follows from each, and sets that
// contradict themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/scene_renderer.h"
#include "core/image/overlay.h"
#include "tasks/trace_shape/contour.h"
#include "tests/env_helpers.h"
#include "tests/tasks/variants/constant_text.h"

namespace engram {
namespace {

using Catch::Contains, tasks::Contour, tasks::ContourSet, tasks::Vec2, test::flag, test::row;

constexpr const char* kEasy = "TraceShapeEasy-VLA-v0";
constexpr const char* kHard = "TraceShapeHard-VLA-v0";
constexpr const char* kSeq = "TraceShapeSeqHard-VLA-v0";
constexpr int kRed = 0;
constexpr int kGreen = 1;
const Vec2 kCenter(-0.1, 0.05);

// Without physics, shapes about kCenter.
std::unique_ptr<Batch> make(const char* id, const ConstantTable& constants, std::vector<Pin> pins) {
  MakeOptions options{{.reward_mode = RewardMode::kDense,
                       .auto_reset = AutoReset::kOff,
                       .terminate_on_success = false,
                       .substeps = 0,
                       .pins = std::move(pins)},
                      constants};
  options.pins.push_back({"center_x", {kCenter.x()}});
  options.pins.push_back({"center_y", {kCenter.y()}});
  options.pins.push_back({"pre_demo_steps", {4}});
  return test::make_running(id, options);
}

// A circle of 10 cm.
std::unique_ptr<Batch> make_circle(const ConstantTable& constants) {
  return make(kHard, constants, {{"shape", {0}}, {"radius", {0.1}}, {"rotation", {0}}});
}

void rest(Batch& batch) { test::step(batch, Policy::kZero); }
void wait(Batch& batch) {
  while (batch.state().elapsed[0] < Queries(batch).cue_end(0)) rest(batch);
}
void put_green(Batch& batch, const Vec2& where) {
  const double pos[3] = {where.x(), where.y(), 0.02};
  const double upright[4] = {1, 0, 0, 0};
  batch.state().place_prop(0, kGreen, pos, upright, PropStatus::kAsleep);
  rest(batch);
}
Vec2 place(const Batch& batch, int prop) {
  return {batch.state().prop_pos_of(0, prop)[0], batch.state().prop_pos_of(0, prop)[1]};
}
float number(const Batch& batch, const char* name) { return *row<float>(batch.output(name), 0); }

TEST_CASE("AVAILABLE_SHAPES are drawn, and pinned by their place in the list",
          "[variants][trace]") {
  const ConstantTable constants = {
      {"AVAILABLE_SHAPES", ConstantList{std::string("triangle"), std::string("circle")}}};
  const auto task = make_task(kEasy, constants);
  const TaskInfo& info = task->info();
  CHECK(info.candidates == 2);
  CHECK(info.hidden_variable == "shape");
  CHECK(test::constant_text(info, "AVAILABLE_SHAPES") == "[2, 0]");
  CHECK((info.random_variables[0].high == 1 &&
         info.random_variables[0].description == "0 triangle, 1 circle"));
  const auto batch = test::make_running(kEasy, MakeOptions{{.num_envs = 30}, constants});
  std::set<int> seen;
  for (int i = 0; i < 30; ++i) seen.insert(*row<std::int32_t>(batch->output("oracle_info"), i));
  CHECK(seen == std::set<int>{0, 2});
  const std::vector<Pin> first = {{"shape", {0}}};
  batch->reset({.mask = {}, .seeds = {}, .pins = &first});
  CHECK(*row<std::int32_t>(batch->output("oracle_info"), 0) == 2);
}

TEST_CASE("NUM_WAYPOINTS is how long a shape is shown", "[variants][trace]") {
  for (const int waypoints : {24, 64, 150}) {
    INFO(waypoints);
    const auto batch = make(kHard, {{"NUM_WAYPOINTS", waypoints}},
                            {{"shape", {1}}, {"radius", {0.1}}, {"rotation", {0.3}}});
    CHECK(Queries(*batch).cue_end(0) == 4 + waypoints);
    const ContourSet set({.NUM_WAYPOINTS = waypoints});
    const Contour contour(set, tasks::SHAPE_SQUARE, 0.1, 0.3, kCenter);
    for (int t = 0; t < 4 + waypoints; ++t) {
      REQUIRE((place(*batch, kRed) - contour.waypoint(std::max(0, t - 4))).norm() < 1e-12);
      CHECK_FALSE(flag(*batch, "action_mask"));
      rest(*batch);
    }
    CHECK(flag(*batch, "action_mask"));
    CHECK_THAT(batch->info().phases[1].second, Contains("P + " + std::to_string(waypoints)));
  }
}

TEST_CASE("Waypoints divide shapes evenly, whatever their number", "[variants][trace]") {
  for (const int waypoints : {24, 50, 64, 101}) {
    const ContourSet set({.NUM_WAYPOINTS = waypoints});
    const double lengths[] = {2 * std::numbers::pi, 8, 3 * std::sqrt(3.0)};
    for (int shape = 0; shape < tasks::kContourShapes; ++shape) {
      INFO(waypoints << " " << shape);
      const Contour contour(set, shape, 1, 0, {0, 0});
      for (int i = 0; i < waypoints; ++i) {
        const double step = (contour.waypoint((i + 1) % waypoints) - contour.waypoint(i)).norm();
        CHECK(step < lengths[shape] / waypoints + 1e-9);
        CHECK(step > 0.49 * lengths[shape] / waypoints);  // corners are cut
      }
    }
  }
}

TEST_CASE("NUM_CHECKPOINTS have to be visited", "[variants][trace]") {
  for (const int checkpoints : {3, 12, 30}) {
    INFO(checkpoints);
    const auto batch = make_circle({{"NUM_CHECKPOINTS", checkpoints}, {"CHECKPOINT_THRESH", 0.01}});
    wait(*batch);
    const ContourSet set({.NUM_CHECKPOINTS = checkpoints});
    const Contour circle(set, tasks::SHAPE_CIRCLE, 0.1, 0, kCenter);
    for (int i = 0; i < checkpoints; ++i) {
      CHECK(number(*batch, "visit_fraction") == Approx(static_cast<double>(i) / checkpoints));
      put_green(*batch, circle.checkpoint(i));
      CHECK(row<std::uint8_t>(batch->output("checkpoint_visited"), 0)[i] == 1);
    }
    CHECK(flag(*batch, "all_visited"));
    CHECK_FALSE(flag(*batch, "success"));
    put_green(*batch, circle.checkpoint(0));
    CHECK(flag(*batch, "success"));
    CHECK(batch->outputs().reward[0] == 30);
  }
}

TEST_CASE("A checkpoint is visited within CHECKPOINT_THRESH", "[variants][trace]") {
  for (const double threshold : {0.01, 0.035, 0.06}) {
    INFO(threshold);
    for (const bool near : {true, false}) {
      // Three checkpoints 17 cm apart: no place is near two of them.
      const auto batch = make_circle({{"NUM_CHECKPOINTS", 3}, {"CHECKPOINT_THRESH", threshold}});
      wait(*batch);
      const Vec2 out(threshold + (near ? -1e-6 : 1e-6), 0);
      put_green(*batch, kCenter + Vec2(0.1, 0) + out);
      CHECK((row<std::uint8_t>(batch->output("checkpoint_visited"), 0)[0] == 1) == near);
    }
  }
}

TEST_CASE("SHAPE_RADIUS_RANGE is what radii are drawn from, and resets narrow it",
          "[variants][trace]") {
  const auto batch = test::make_env(
      kHard, MakeOptions{{.num_envs = 40}, {{"SHAPE_RADIUS_RANGE", ConstantList{0.05, 0.06}}}});
  const auto radii = [&batch] {
    std::vector<double> values;
    for (int i = 0; i < 40; ++i)
      values.push_back(*row<double>(test::memory_of(*batch).find("radii"), i));
    std::ranges::sort(values);
    return values;
  };
  batch->reset();
  CHECK((radii().front() >= 0.05 && radii().front() < 0.052));
  CHECK((radii().back() <= 0.06 && radii().back() > 0.058));
  const ConstantTable narrow = {{"SHAPE_RADIUS_RANGE", ConstantList{0.054, 0.055}}};
  batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &narrow});
  CHECK((radii().front() >= 0.054 && radii().back() <= 0.055));
}

TEST_CASE("Lengths of sequences change answers, columns and observation", "[variants][trace]") {
  const ConstantTable constants = {{"MIN_SEQUENCE_LENGTH", 1}, {"MAX_SEQUENCE_LENGTH", 3}};
  const auto task = make_task(kSeq, constants);
  CHECK(task->info().candidates == 3 + 9 + 27);
  CHECK(task->info().oracle_dim == 3);
  const auto batch = test::make_running(kSeq, MakeOptions{{.num_envs = 40}, constants});
  CHECK(batch->state_dim() == test::make_env(kSeq)->state_dim() - 2);
  std::set<int> lengths;
  for (int i = 0; i < 40; ++i) {
    const int length = *row<std::int32_t>(test::memory_of(*batch).find("sequence_length"), i);
    lengths.insert(length);
    for (int k = 0; k < 3; ++k) {
      CHECK((row<std::int32_t>(batch->output("oracle_info"), i)[k] < 0) == (k >= length));
    }
  }
  CHECK(lengths == std::set<int>{1, 2, 3});
}

TEST_CASE("A sequence of one shape is shown for as long as one", "[variants][trace]") {
  const auto batch = make(kSeq, {{"MIN_SEQUENCE_LENGTH", 1}, {"MAX_SEQUENCE_LENGTH", 1}},
                          {{"shapes", {2}}, {"sequence_length", {1}}});
  CHECK(Queries(*batch).cue_end(0) == 4 + 64);
  CHECK(batch->info().hidden_variable == "shapes");
}

TEST_CASE("The chance of a guess grows with what is allowed", "[variants][trace]") {
  const auto chance = [](const char* id, const ConstantTable& constants) {
    return make_task(id, constants)->info().chance();
  };
  CHECK(chance(kHard, {}) == 0.33);
  CHECK(chance(kHard, {{"CHECKPOINT_THRESH", 0.01}}) < 0.1);
  CHECK(chance(kHard, {{"CHECKPOINT_THRESH", 0.06}}) > 0.5);
  CHECK(chance(kHard, {{"SHAPE_RADIUS_RANGE", ConstantList{0.04, 0.05}}}) > 0.6);
  CHECK(chance(kEasy, {{"SHAPE_RADIUS_RANGE", 0.1}}) > 0.9);
  CHECK(chance(kSeq, {{"MIN_SEQUENCE_LENGTH", 5}}) < 0.05);
  // The estimate agrees with what was measured.
  CHECK(chance(kHard, {{"SHAPE_RADIUS_RANGE", ConstantList{0.078, 0.1301}}}) ==
        Approx(0.33).margin(0.03));
  CHECK(chance(kEasy, {{"SHAPE_RADIUS_RANGE", ConstantList{0.078, 0.1301}}}) ==
        Approx(0.86).margin(0.03));
}

TEST_CASE("The map shows the largest shape", "[variants][trace]") {
  const auto batch = make(kEasy, {{"SHAPE_RADIUS_RANGE", 0.2}}, {{"radius", {0.2}}});
  wait(*batch);
  // Half of the map's 160 pixels show 23 cm.
  Overlay overlay;
  SceneRenderer(*batch).overlay(0, overlay);
  double left = 1e9;
  for (const OverlayItem& item : overlay.items) {
    if (const auto* line = std::get_if<OverlayLine>(&item)) {
      for (const OverlayPoint& point : line->points) left = std::min(left, point.x);
    }
  }
  CHECK(left == Approx(10 + 80 - 80 * 0.2 / 0.23).margin(0.1));
}

TEST_CASE("Penalties of the tracing tasks have the weights of their constants",
          "[variants][trace]") {
  const auto reward = [](const char* id, const ConstantTable& constants) {
    const auto batch = test::make_running(
        id, MakeOptions{{.reward_mode = RewardMode::kDense, .substeps = 0}, constants});
    std::vector<float> action = test::zeros(*batch);
    action[0] = 1;
    batch->step(action);
    return batch->outputs().reward[0];
  };
  for (const char* id : {kHard, kSeq}) {
    CHECK(reward(id, {}) - reward(id, {{"ACTION_L2_COEF", 1}}) ==
          Approx(0.99 * std::tanh(2.0)).margin(1e-5));
  }
}

TEST_CASE("Sets of the tracing tasks that contradict themselves are refused", "[variants][trace]") {
  struct Case {
    const char* id;
    ConstantTable constants;
    const char* message;
  };
  const std::vector<Case> cases = {
      {kHard,
       {{"NUM_CHECKPOINTS", 30}, {"NUM_WAYPOINTS", 24}},
       "30 given, at most NUM_WAYPOINTS 24"},
      {kHard,
       {{"NUM_WAYPOINTS", 300}},
       "PRE_DEMO_STEPS 8 + 1 x NUM_WAYPOINTS 300 = 300 + 50 to act = 358 control steps, more than "
       "max_episode_steps 350"},
      {kHard,
       {{"SHAPE_RADIUS_RANGE", ConstantList{0.1, 0.15}}},
       "for corners within 0.2 m allowed"},
      {kHard, {{"SHAPE_RADIUS_RANGE", ConstantList{0.12, 0.1}}}, "least and greatest"},
      {kHard, {{"AVAILABLE_SHAPES", std::string("star")}}, "circle, square, triangle"},
      {kHard, {{"MAX_SEQUENCE_LENGTH", 3}}, "no constant named"},
      {kSeq, {{"MIN_SEQUENCE_LENGTH", 6}}, "6 given, at most MAX_SEQUENCE_LENGTH 5 allowed"},
      {kSeq, {{"NUM_WAYPOINTS", 300}}, "5 x NUM_WAYPOINTS 300 = 1500"},
  };
  for (const Case& refused : cases) {
    CHECK_THROWS_WITH(make_task(refused.id, refused.constants), Contains(refused.message));
  }
}

}  // namespace
}  // namespace engram
