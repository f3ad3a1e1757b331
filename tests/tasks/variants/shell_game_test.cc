// Shell games with other constants: what follows from each, and sets that contradict themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "mjcf/mug.h"
#include "protocol/make/make.h"
#include "tests/env_helpers.h"
#include "tests/tasks/shell_game/ids.h"
#include "tests/tasks/variants/constant_text.h"

namespace engram {
namespace {

using Catch::Contains, Eigen::Vector3d, test::make_reset, test::row;
using namespace test::shell_game;

constexpr const char* kAll[] = {kTouch, kPush, kPick, kLamp, kShuffle, kShuffleLamp};
constexpr double kRest = mjcf::kMugRestingHeight;

Vector3d pos(const Batch& batch, int prop, int index = 0) {
  return Eigen::Map<Vector3d>(batch.state().prop_pos_of(index, prop));
}
void put(const Batch& batch, int prop, const Vector3d& there) {
  std::copy_n(there.data(), 3, batch.state().prop_pos_of(0, prop));
}
int memory_int(const Batch& batch, const char* name, int index = 0) {
  return *row<std::int32_t>(test::memory_of(batch).find(name), index);
}

// Nothing moves but what a test moves.
MakeOptions still(std::vector<Pin> pins) {
  MakeOptions options;
  options.substeps = 0;
  options.terminate_on_success = false;
  options.reward_mode = RewardMode::kDense;
  options.pins = std::move(pins);
  return options;
}

// Goes on until the robot may act.
void wait(Batch& batch) {
  const int start = memory_int(batch, "manipulation_start");
  while (batch.state().elapsed[0] < start) test::step(batch, Policy::kZero);
}

TEST_CASE("Constants of shell games show in the description", "[variants][shell]") {
  for (const char* id : kAll) {
    INFO(id);
    const auto task = make_task(id, {{"BALL_RADIUS", 0.025}, {"MIN_DIST", 0.25}});
    CHECK(test::constant_text(task->info(), "BALL_RADIUS") == "0.025");
    CHECK(test::constant_text(task->info(), "MIN_DIST") == "0.25");
    CHECK(test::constant_text(task->info(), "MUG_SCALE") == "1.3");
    CHECK(task->info().candidates == 3);
  }
}

TEST_CASE("Cups grow with MUG_SCALE, and so does where they stand", "[variants][shell]") {
  for (const char* id : {kTouch, kPick, kLamp, kShuffle}) {
    INFO(id);
    const ConstantTable twice = {{"MUG_SCALE", 2}, {"MIN_DIST", 0.3}, {"GOAL_THRESH", 0.11}};
    const ConstantTable lift = {{"MUG_SCALE", 2}, {"MIN_DIST", 0.3}, {"GOAL_THRESH", 0.03}};
    const auto batch = make_reset(id, id == kPick ? lift : twice, still({{"cue_steps", {1}}}));
    const auto usual = make_reset(id, {});
    const double ratio = 2 / 1.3;
    const PropModel& mug = batch->physics_model().props()[0];
    const PropModel& before = usual->physics_model().props()[0];
    CHECK(mug.mass == Approx(before.mass * ratio * ratio * ratio));
    CHECK(mug.bounding_radius == Approx(before.bounding_radius * ratio));
    CHECK((mug.body.center() - ratio * before.body.center()).norm() < 1e-9);
    wait(*batch);
    for (int cup = 0; cup < 3; ++cup) CHECK(pos(*batch, cup).z() == Approx(kRest * ratio));
  }
  // Inertia about the centre of mass: density x length^5.
  const mjcf::Prop one = mjcf::mug("mug");
  const mjcf::Prop twice = mjcf::mug("mug", mjcf::kMugHandleYaw, 2.6);
  for (std::size_t i = 0; i < 6; ++i) CHECK(twice.inertia[i] == Approx(32 * one.inertia[i]));
  for (std::size_t i = 0; i < one.geoms.size(); ++i) {
    CHECK(twice.geoms[i].size[0] == Approx(2 * one.geoms[i].size[0]));
    CHECK(twice.geoms[i].pos[2] == Approx(2 * one.geoms[i].pos[2]));
  }
}

TEST_CASE("A large cup stands on its rim and does not creep", "[variants][shell]") {
  for (const double scale : {0.7, 1.6}) {
    MakeOptions options;
    options.sleep = false;
    options.pins = {{"cue_steps", {1}}, {"base", {0.1, 0}}};
    const auto batch = make_reset(kPush, {{"MUG_SCALE", scale}}, options);
    test::step(*batch, Policy::kZero);
    const Vector3d before = pos(*batch, 1);
    for (int t = 0; t < 20; ++t) test::step(*batch, Policy::kZero);
    CHECK((pos(*batch, 1) - before).norm() < 5e-4);
  }
}

TEST_CASE("Balls have BALL_RADIUS, slots are MIN_DIST apart", "[variants][shell]") {
  for (const char* id : kAll) {
    INFO(id);
    const auto batch = make_reset(id, {{"BALL_RADIUS", 0.03}, {"MIN_DIST", 0.25}},
                                  still({{"cue_steps", {1}}, {"base", {0.02, -0.04}}}));
    const bool lamp = id == kLamp || id == kShuffleLamp;
    const char* const ball = lamp ? "ball_red" : "red_ball";
    CHECK(test::size_in(make_task(id, {{"BALL_RADIUS", 0.03}})->document(), ball) == 0.03);
    CHECK(pos(*batch, 3).z() == 0.03);
    CHECK(std::remainder(pos(*batch, 3).y() + 0.04, 0.25) == Approx(0).margin(1e-12));
    wait(*batch);
    std::set<int> slots;
    for (int cup = 0; cup < 3; ++cup) {
      const double steps = (pos(*batch, cup).y() + 0.04) / 0.25;
      CHECK(steps == Approx(std::round(steps)).margin(1e-9));
      slots.insert(static_cast<int>(std::lround(steps)));
    }
    CHECK(slots == std::set<int>{-1, 0, 1});
  }
}

TEST_CASE("Phases are as long as they were made", "[variants][shell]") {
  struct Range {
    const char* constant;
    const char* column;
    int low, high;
  };
  const std::vector<Range> ranges = {{"CUE_PHASE_STEPS", "cue_steps", 7, 9},
                                     {"SHUFFLE_PHASE_STEPS", "shuffle_steps", 40, 42},
                                     {"NUM_SWAPS", "num_swaps", 6, 8}};
  for (const char* id : kAll) {
    const bool shuffles = id == kShuffle || id == kShuffleLamp;
    MakeOptions options;
    options.num_envs = 60;
    ConstantTable constants = {{"max_episode_steps", 80}};
    for (std::size_t i = 0; i < (shuffles ? 3 : 1); ++i) {
      constants.emplace_back(ranges[i].constant, ConstantList{ranges[i].low, ranges[i].high});
    }
    const auto batch = make_reset(id, constants, options);
    CHECK(batch->info().horizon == 80);
    for (std::size_t i = 0; i < (shuffles ? 3 : 1); ++i) {
      INFO(id << " " << ranges[i].constant);
      std::set<int> seen;
      for (int e = 0; e < 60; ++e) seen.insert(memory_int(*batch, ranges[i].column, e));
      CHECK(*seen.begin() == ranges[i].low);
      CHECK(*seen.rbegin() == ranges[i].high);
      const auto draw = std::ranges::find(batch->info().random_variables,
                                          std::string(ranges[i].column), &RandomVariable::name);
      REQUIRE(draw != batch->info().random_variables.end());
      CHECK(draw->low == ranges[i].low);
      CHECK(draw->high == ranges[i].high);
    }
    for (int e = 0; e < 60; ++e)
      CHECK(Queries(*batch).cue_end(e) == memory_int(*batch, "cue_steps", e));
    // Resets may narrow them.
    for (std::size_t i = 0; i < (shuffles ? 3 : 1); ++i) {
      const ConstantTable easy = {{ranges[i].constant, ranges[i].low}};
      batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &easy});
      for (int e = 0; e < 60; ++e) CHECK(memory_int(*batch, ranges[i].column, e) == ranges[i].low);
    }
    if (!shuffles) continue;
    const auto pairs =
        std::ranges::find(batch->info().random_variables, "swap_pairs", &RandomVariable::name);
    CHECK(pairs->width == 8);
    CHECK(test::memory_of(*batch).find("slots_after_swaps").field->width == 27);
  }
}

TEST_CASE("Cups that swap rise by SWAP_ARC_HEIGHT", "[variants][shell]") {
  for (const char* id : {kShuffle, kShuffleLamp}) {
    for (const double height : {0.0, 0.03, 0.12}) {
      INFO(id << " " << height);
      const auto batch =
          make_reset(id, {{"SWAP_ARC_HEIGHT", height}},
                     still({{"cue_steps", {1}}, {"shuffle_steps", {24}}, {"num_swaps", {2}}}));
      double highest = 0;
      for (int t = 0; t < 30; ++t) {
        test::step(*batch, Policy::kZero);
        highest = std::max(highest, pos(*batch, 0).z() - kRest);
      }
      CHECK(highest == Approx(height).margin(1e-9));  // reached in the middle of a swap
    }
  }
}

TEST_CASE("A touch is as near as GOAL_THRESH", "[variants][shell]") {
  for (const double thresh : {0.07, 0.12}) {
    const auto batch = make_reset(kTouch, {{"GOAL_THRESH", thresh}},
                                  still({{"cue_steps", {1}}, {"cup_with_ball_number", {1}}}));
    const Vector3d tcp = Eigen::Map<Vector3d>(batch->state().tcp_pos.row(0));
    wait(*batch);
    double* reference =
        const_cast<double*>(row<double>(test::memory_of(*batch).find("mug_reference"), 0));
    std::copy_n(tcp.data(), 2, reference + 2);
    const auto step_at = [&](double distance) {
      put(*batch, 1, tcp + Vector3d(0, 0, distance));
      test::step(*batch, Policy::kZero);
      return batch->outputs().success[0] != 0;
    };
    CHECK(step_at(thresh - 1e-9));
    CHECK(batch->outputs().reward[0] == 3);
    CHECK_FALSE(step_at(thresh + 1e-9));
    CHECK(batch->outputs().reward[0] < 1);  // nothing for being placed
  }
  // The answer of the lamp game is a place, to which the tool has to come.
  for (const char* id : {kLamp, kShuffleLamp, kShuffle}) {
    INFO(id);
    const auto batch = make_reset(id, {{"GOAL_THRESH", 0.15}, {"max_episode_steps", 100}});
    const auto near = make_reset(id, {{"GOAL_THRESH", 0.07}, {"max_episode_steps", 100}});
    int first[2] = {0, 0};
    for (int t = 1; t < 100; ++t) {
      int i = 0;
      for (Batch* one : {batch.get(), near.get()}) {
        test::step(*one, Policy::kOracle);
        const float* offset = row<float>(one->output("obj_to_goal_pos"), 0);
        const double distance = Eigen::Map<const Eigen::Vector3f>(offset).cast<double>().norm();
        const bool placed = *row<std::uint8_t>(one->output("is_obj_placed"), 0) != 0;
        CHECK(placed == (distance <= (i == 0 ? 0.15 : 0.07)));
        if (placed && first[i] == 0) first[i] = t;
        ++i;
      }
    }
    CHECK(0 < first[0]);
    CHECK(first[0] < first[1]);
  }
}

TEST_CASE(
    "A cup that is moved has to come within 1.6 GOAL_THRESH of the goal by the original's rules",
    "[variants][shell][rules]") {
  for (const bool push : {true, false}) {
    for (const double radius : {0.02, 0.03}) {
      const double thresh = 0.03;
      INFO((push ? kPush : kPick) << " " << radius);
      const ConstantTable constants = {
          {"GOAL_THRESH", thresh}, {"BALL_RADIUS", radius}, {"MUG_SCALE", 1.0}};
      MakeOptions options = still({{"cue_steps", {1}}, {"cup_with_ball_number", {0}}});
      options.rules = Rules::kOriginal;
      const auto batch = make_reset(push ? kPush : kPick, constants, options);
      wait(*batch);
      const Vector3d home = pos(*batch, 0);
      const Vector3d goal = push ? Vector3d(home.x() + 0.1, home.y(), radius + 0.03)
                                 : Vector3d(home.x(), home.y(), radius + 0.125);
      CHECK((pos(*batch, 4) - goal).norm() < 1e-12);
      CHECK(test::size_in(make_task(push ? kPush : kPick, constants)->document(), "goal_site") ==
            thresh);
      const auto result = [&](double distance) {
        put(*batch, 0, goal + Vector3d(0, distance, 0));
        test::step(*batch, Policy::kZero);
        return batch->outputs().success[0] != 0;
      };
      CHECK(result(1.6 * thresh - 1e-9));
      CHECK_FALSE(result(1.6 * thresh + 1e-9));
    }
  }
}

struct Refused {
  const char* id;
  ConstantTable constants;
  const char* says;
};

TEST_CASE("Shell games that contradict themselves are refused", "[variants][shell]") {
  const std::vector<Refused> refused = {
      {kTouch, {{"MIN_DIST", 0.15}}, "MIN_DIST 0.15 m leaves -2 mm between two"},
      {kTouch, {{"MUG_SCALE", 1.75}, {"GOAL_THRESH", 0.1}}, "do not stand apart"},
      {kLamp, {{"BALL_RADIUS", 0.044}}, "at most 43 mm allowed"},
      {kShuffle, {{"BALL_RADIUS", 0.04}, {"MUG_SCALE", 1}}, "would not hide the ball"},
      {kTouch, {{"GOAL_THRESH", 0.06}}, "at least 69 mm allowed"},
      {kLamp, {{"MUG_SCALE", 1.6}}, "at least 81 mm allowed"},
      {kShuffleLamp, {{"GOAL_THRESH", 0.2}}, "less than MIN_DIST 0.2 allowed"},
      {kPush, {{"GOAL_THRESH", 0.01}, {"BALL_RADIUS", 0.04}}, "never are in the goal region"},
      {kPick, {{"MIN_DIST", 0.14}}, "at least 28 mm allowed"},
      {kTouch, {{"CUE_PHASE_STEPS", 25}}, "CUE_PHASE_STEPS 25 + 12 to act = 37 control steps"},
      {kPick, {{"CUE_PHASE_STEPS", ConstantList{1, 12}}}, "12 + 19 to act = 31 control steps"},
      {kShuffle, {{"NUM_SWAPS", 11}}, "NUM_SWAPS 11 x 2 control steps = 22"},
      {kShuffleLamp, {{"SHUFFLE_PHASE_STEPS", 50}}, "SHUFFLE_PHASE_STEPS 50 + 12 to act = 67"},
      {kShuffle, {{"NUM_SWAPS", 41}}, "whole numbers from 1 to 40"},
      {kTouch, {{"NUM_SWAPS", 3}}, "no constant named 'NUM_SWAPS'"},
      {kTouch, {{"MUG_SCALE", 2.5}}, "a number from 0.7 to 2"},
  };
  for (const Refused& row : refused) {
    INFO(row.id << ": " << row.says);
    CHECK_THROWS_WITH(make_task(row.id, row.constants), Contains(row.says));
  }
}

TEST_CASE("Goal regions that contradict the original's rules are refused under these",
          "[variants][shell][rules]") {
  const std::vector<Refused> refused = {
      {kPush, {{"GOAL_THRESH", 0.063}}, "in the goal region from the start"},
      {kPick, {{"GOAL_THRESH", 0.058}}, "1.6 x GOAL_THRESH = 93 mm"},
      {kPick, {{"MUG_SCALE", 1.6}}, "in the goal region from the start"},
  };
  for (const Refused& row : refused) {
    INFO(row.id << ": " << row.says);
    MakeOptions options{{}, row.constants};
    CHECK_NOTHROW(make(row.id, options));
    options.rules = Rules::kOriginal;
    CHECK_THROWS_WITH(make(row.id, options), Contains(row.says));
  }
}

TEST_CASE("Penalties lower the reward of a shuffle's last phase", "[variants][shell]") {
  const auto reward = [](const ConstantTable& constants, float push) {
    const auto batch =
        make_reset(kShuffle, constants, still({{"cue_steps", {1}}, {"shuffle_steps", {20}}}));
    wait(*batch);
    std::vector<float> action = test::zeros(*batch);
    action[2] = push;
    batch->step(action);
    return static_cast<double>(batch->outputs().reward[0]);
  };
  const double usual = reward({}, -0.4F);
  CHECK(reward({{"ACTION_L2_COEF", 0.0}}, -0.4F) == usual);
  CHECK(usual - reward({{"ACTION_L2_COEF", 0.5}}, -0.4F) ==
        Approx(0.5 * std::tanh(2 * 0.4)).margin(1e-6));
  CHECK(usual - reward({{"ACTION_DELTA_L2_COEF", 0.5}}, -0.4F) ==
        Approx(0.5 * std::tanh(5 * 0.4)).margin(1e-6));
  CHECK(reward({{"QVEL_L2_COEF", 0.5}}, 0) == reward({}, 0));  // nothing moves
}

}  // namespace
}  // namespace engram
