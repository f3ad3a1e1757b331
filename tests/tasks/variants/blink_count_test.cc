// BlinkCountButtonPress with other constants: what follows from each, and sets that contradict
// themselves.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/batch/queries.h"
#include "tasks/blink_count/reward.h"
#include "tests/env_helpers.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/variants/constant_text.h"

namespace engram {
namespace {

using Catch::Contains, Eigen::Vector3d, test::flag, test::row;

constexpr const char* kEasy = "BlinkCountButtonPressEasy-VLA-v0";
const Vector3d kFarAway(-0.1, 0, 0.4);

enum Prop { kRedBase, kRedCap, kBlackBase, kBlackCap };

// Without physics, the red button at (-0.1, 0) and the black one at (-0.1, 0.16).
std::unique_ptr<Batch> make(const ConstantTable& constants, std::vector<Pin> pins = {}) {
  MakeOptions options{{.reward_mode = RewardMode::kDense,
                       .auto_reset = AutoReset::kOff,
                       .substeps = 0,
                       .pins = std::move(pins)},
                      constants};
  options.pins.push_back({"button_x", {-0.1}});
  options.pins.push_back({"button_y", {0}});
  return test::make_running(kEasy, options);
}

// A batch after the cue; `blinks` are to be counted.
std::unique_ptr<Batch> after_cue(const ConstantTable& constants, double blinks = 2) {
  auto batch = make(constants, {{"target_blinks", {blinks}}});
  while (batch->state().elapsed[0] < Queries(*batch).cue_end(0)) test::step_at(*batch, kFarAway);
  return batch;
}

void tool_at(Batch& batch, double height, double aside = 0) {
  test::step_at(batch, {-0.1 + aside, 0, height});
}
int count(const Batch& batch, const char* name) {
  return *row<std::int32_t>(batch.output(name), 0);
}
double prop_height(const Batch& batch, int prop) { return batch.state().prop_pos_of(0, prop)[2]; }

TEST_CASE("BLINK_COUNT_RANGE is what is counted, guessed and drawn", "[variants][blink_count]") {
  const ConstantTable constants = {{"BLINK_COUNT_RANGE", ConstantList{2, 5}},
                                   {"max_episode_steps", 200}};
  const auto task = make_task(kEasy, constants);
  CHECK(task->info().candidates == 4);
  CHECK(task->info().chance() == 0.25);
  CHECK(test::constant_text(task->info(), "BLINK_COUNT_RANGE") == "[2, 5]");
  for (const RandomVariable& draw : task->info().random_variables) {
    if (draw.name == "target_blinks") CHECK((draw.low == 2 && draw.high == 5));
    if (draw.name == "blink_on_steps") CHECK(draw.width == 5);
  }
  const auto batch = test::make_running(kEasy, MakeOptions{{.num_envs = 60}, constants});
  std::set<int> seen;
  for (int i = 0; i < 60; ++i) seen.insert(*row<std::int32_t>(batch->output("target_blinks"), i));
  CHECK(seen == std::set<int>{2, 3, 4, 5});
}

TEST_CASE("Times of blinks make up the cue", "[variants][blink_count]") {
  const auto batch =
      make({{"PRE_BLINK_OFF_STEPS", 4}, {"BLINK_ON_STEPS", 2}, {"BLINK_OFF_STEPS", 6}},
           {{"target_blinks", {3}}});
  CHECK(Queries(*batch).cue_end(0) == 4 + 3 * (2 + 6));
  for (int t = 0; t < 32; ++t) {
    INFO(t);
    CHECK(flag(*batch, "light_on") == (t >= 4 && t < 28 && (t - 4) % 8 < 2));
    CHECK(flag(*batch, "action_mask") == (t >= 28));
    test::step_at(*batch, kFarAway);
  }
}

TEST_CASE("Resets narrow the ranges of blinks", "[variants][blink_count]") {
  const auto batch = test::make_env(
      kEasy, MakeOptions{{.num_envs = 30}, {{"BLINK_ON_STEPS", ConstantList{1, 9}}}});
  const ConstantTable narrow = {{"BLINK_ON_STEPS", 7}, {"BLINK_COUNT_RANGE", 2}};
  batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &narrow});
  for (int i = 0; i < 30; ++i) {
    CHECK(*row<std::int32_t>(batch->output("target_blinks"), i) == 2);
    const auto* lengths = row<std::int32_t>(test::memory_of(*batch).find("blink_length"), i);
    CHECK((lengths[0] == 7 && lengths[1] == 7));
  }
}

TEST_CASE("Both buttons have the size that is asked for", "[variants][blink_count]") {
  const ConstantTable constants = {{"BUTTON_BASE_HALF_SIZE", ConstantList{0.05, 0.06, 0.02}},
                                   {"BUTTON_CAP_RADIUS", 0.04},
                                   {"BUTTON_CAP_HALF_HEIGHT", 0.01}};
  const std::string document = make_task(kEasy, constants)->document();
  for (const std::string name : {"button", "confirm_button"}) {
    CHECK(test::size_in(document, name + "_base") == 0.05);
    CHECK(test::size_in(document, name + "_cap") == 0.04);
  }
  const auto batch = make(constants);
  for (const int base : {kRedBase, kBlackBase}) {
    CHECK(prop_height(*batch, base) == Approx(0.02));
    CHECK(prop_height(*batch, base + 1) == Approx(0.05));  // of the cap
  }
}

// How high a tool is when a press just begins, m, between two heights.
double pressing_height(const ConstantTable& constants, double low, double high) {
  while (high - low > 1e-6) {
    const double middle = (low + high) / 2;
    const auto batch = after_cue(constants);
    tool_at(*batch, middle);
    (flag(*batch, "new_raw_press_event") ? low : high) = middle;
  }
  return low;
}

TEST_CASE("A press begins where the button's constants say", "[variants][blink_count]") {
  // Top of the cap + margin - ratio x travel.
  CHECK(pressing_height({}, 0.05, 0.15) == Approx(0.058 + 0.03 - 0.35 * 0.014).margin(2e-6));
  CHECK(pressing_height({{"BUTTON_PRESS_Z_MARGIN", 0.05}}, 0.05, 0.15) ==
        Approx(0.058 + 0.05 - 0.35 * 0.014).margin(2e-6));
  CHECK(pressing_height({{"BUTTON_PRESS_EVENT_RATIO", 0.8}}, 0.05, 0.15) ==
        Approx(0.058 + 0.03 - 0.8 * 0.014).margin(2e-6));
  CHECK(pressing_height({{"BUTTON_CAP_TRAVEL", 0.02}}, 0.05, 0.15) ==
        Approx(0.058 + 0.03 - 0.35 * 0.02).margin(2e-6));
  CHECK(pressing_height({{"BUTTON_CAP_HALF_HEIGHT", 0.02}}, 0.05, 0.15) ==
        Approx(0.07 + 0.03 - 0.35 * 0.014).margin(2e-6));
  CHECK(pressing_height({{"BUTTON_BASE_HALF_SIZE", ConstantList{0.05, 0.05, 0.03}}}, 0.05, 0.2) ==
        Approx(0.088 + 0.03 - 0.35 * 0.014).margin(2e-6));
}

TEST_CASE("The cap sinks as far as BUTTON_CAP_TRAVEL", "[variants][blink_count]") {
  for (const double travel : {0.007, 0.014, 0.028}) {
    const auto batch = after_cue({{"BUTTON_CAP_TRAVEL", travel}});
    tool_at(*batch, 0.03);
    CHECK(prop_height(*batch, kRedCap) == Approx(0.044 - travel));
    CHECK(*row<float>(batch->output("press_depth"), 0) == Approx(travel));
  }
}

TEST_CASE("Rewards count in travels and lifts", "[variants][blink_count]") {
  tasks::BlinkCountParams params;
  tasks::BlinkReward in{params};
  in.depth = in.black_depth = 0.007;
  in.pending = true;
  in.start_height = 0.07;
  in.height = 0.11;
  for (const double travel : {0.01, 0.014, 0.028}) {
    params.button.BUTTON_CAP_TRAVEL = travel;
    in.compute();
    CHECK(in.press == Approx(0.007 / travel));
    CHECK(in.black_press == Approx(0.007 / travel));
  }
  for (const double lift : {0.02, 0.1, 0.2}) {
    params.button.REQUIRED_LIFT_HEIGHT = lift;
    in.compute();
    CHECK(in.lift_gap == Approx(std::max(0.0, lift - 0.04)).margin(1e-12));
  }
}

TEST_CASE("A press counts within BUTTON_PRESS_XY_RADIUS", "[variants][blink_count]") {
  for (const double radius : {0.02, 0.065, 0.08}) {
    INFO(radius);
    const ConstantTable constants = {{"BUTTON_PRESS_XY_RADIUS", radius}};
    const auto inside = after_cue(constants);
    tool_at(*inside, 0.07, radius - 1e-4);
    CHECK(flag(*inside, "new_raw_press_event"));
    const auto outside = after_cue(constants);
    tool_at(*outside, 0.07, radius + 1e-4);
    CHECK_FALSE(flag(*outside, "new_raw_press_event"));
  }
}

TEST_CASE("A button is released at BUTTON_RELEASE_READY_RATIO", "[variants][blink_count]") {
  for (const double ratio : {0.0, 0.2, 0.3}) {
    INFO(ratio);
    const auto batch = after_cue({{"BUTTON_RELEASE_READY_RATIO", ratio}});
    const double released = 0.088 - ratio * 0.014;
    tool_at(*batch, 0.07);
    tool_at(*batch, released - 1e-5);
    CHECK_FALSE(flag(*batch, "new_release_event"));
    tool_at(*batch, released + 1e-5);
    CHECK(flag(*batch, "new_release_event"));
  }
}

TEST_CASE("A press counts after a lift of REQUIRED_LIFT_HEIGHT", "[variants][blink_count]") {
  for (const double lift : {0.04, 0.1, 0.25}) {
    INFO(lift);
    const auto batch = after_cue({{"REQUIRED_LIFT_HEIGHT", lift}});
    tool_at(*batch, 0.08);
    CHECK(*row<float>(batch->output("lift_target_z"), 0) == Approx(0.08 + lift));
    tool_at(*batch, 0.08 + lift - 0.015 - 1e-5);
    CHECK(count(*batch, "press_count") == 0);
    tool_at(*batch, 0.08 + lift - 0.015 + 1e-5);
    CHECK(count(*batch, "press_count") == 1);
  }
}

TEST_CASE("Penalties have the weights of their constants", "[variants][blink_count]") {
  const auto reward = [](const ConstantTable& constants) {
    const auto batch = after_cue(constants);
    std::vector<float> action = test::zeros(*batch);
    action[0] = 1;
    test::pose_tool(*batch, kFarAway);
    batch->step(action);
    return batch->outputs().reward[0];
  };
  const float none =
      reward({{"ACTION_L2_COEF", 0}, {"ACTION_DELTA_L2_COEF", 0}, {"QVEL_L2_COEF", 0}});
  const double own = 0.01 * std::tanh(2.0) + 0.03 * std::tanh(5.0);
  CHECK(none - reward({}) == Approx(own).margin(1e-6));
  CHECK(none - reward({{"ACTION_L2_COEF", 2}}) == Approx(own + 1.99 * std::tanh(2.0)).margin(1e-6));
}

TEST_CASE("Blinking that contradicts itself is refused", "[variants][blink_count]") {
  struct Case {
    ConstantTable constants;
    const char* message;
  };
  const std::vector<Case> cases = {
      {{{"BLINK_COUNT_RANGE", ConstantList{1, 12}}},
       "PRE_BLINK_OFF_STEPS 10 + 12 x (BLINK_ON_STEPS 3 + BLINK_OFF_STEPS 5) = 96 + 143 to act = "
       "249 control steps, more than max_episode_steps 150"},
      {{{"BLINK_ON_STEPS", 40}}, "leave no time to act"},
      {{{"BLINK_OFF_STEPS", 0}}, "from 1 to 1000"},
      {{{"BUTTON_CAP_RADIUS", 0.07}}, "at most 0.065, half the base's side, allowed"},
      {{{"BUTTON_CAP_TRAVEL", 0.03}}, "at most 0.028, the cap's height, allowed"},
      {{{"BUTTON_PRESS_EVENT_RATIO", 0.2}}, "less than BUTTON_PRESS_EVENT_RATIO 0.2 allowed"},
      {{{"BUTTON_PRESS_XY_RADIUS", 0.081}}, "at most half of the 0.16 m between the two buttons"},
      {{{"BUTTON_BASE_HALF_SIZE", ConstantList{0.05, 0.09, 0.01}}}, "between the two buttons"},
      {{{"BUTTON_BASE_HALF_SIZE", 0.05}}, "3 numbers"},
      {{{"BUTON_CAP_TRAVEL", 0.02}}, "did you mean 'BUTTON_CAP_TRAVEL'"},
  };
  for (const Case& refused : cases) {
    CHECK_THROWS_WITH(make_task(kEasy, refused.constants), Contains(refused.message));
  }
}

}  // namespace
}  // namespace engram
