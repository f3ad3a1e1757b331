// TimedTransfer with other constants: what follows from each, and sets that are refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "core/batch/queries.h"
#include "tests/tasks/variants/constant_text.h"
#include "tests/tasks/variants/moved_props.h"

namespace engram {
namespace {

using Catch::Contains, test::flag;

constexpr const char* kId = "TimedTransferEasy-VLA-v0";
constexpr int kRedDisc = 1;
constexpr int kCube = 2;

// The values of elapsed for which a cube may arrive, the signal coming in the second step.
std::pair<int, int> window(const ConstantTable& constants) {
  const auto batch = test::make_still(kId, constants, {{"signal_step", {2}}});
  std::pair<int, int> steps = {0, 0};
  for (int elapsed = 1; !flag(*batch, "past_window"); ++elapsed) {
    test::step(*batch, Policy::kZero);
    if (!flag(*batch, "in_window")) continue;
    if (steps.first == 0) steps.first = elapsed;
    steps.second = elapsed;
  }
  return steps;
}

TEST_CASE("Delay and tolerance say when the cube may arrive", "[variants][timed]") {
  CHECK(window({}) == std::pair(97, 107));
  CHECK(window({{"DELAY_STEPS", 60}}) == std::pair(59, 65));
  CHECK(window({{"DELAY_STEPS", 70}}) == std::pair(69, 75));
  CHECK(window({{"DELAY_STEPS", 120}}) == std::pair(116, 128));
  CHECK(window({{"TOLERANCE_FRAC", 0.29}}) == std::pair(73, 131));
  CHECK(window({{"TOLERANCE_FRAC", 0}}) == std::pair(102, 102));
  CHECK(window({{"TOLERANCE_FRAC", 0.5}}) == std::pair(52, 152));
}

TEST_CASE("Chance, phases, constants and instruction follow delay and tolerance",
          "[variants][timed]") {
  const auto task = make_task(kId, {{"DELAY_STEPS", 120}, {"TOLERANCE_FRAC", 0.5}});
  const TaskInfo& info = task->info();
  CHECK(info.candidates == 241);
  CHECK(info.chance() == Approx(121.0 / 241));
  CHECK(test::constant_text(info, "DELAY_STEPS") == "120");
  CHECK(test::constant_text(info, "TOLERANCE_FRAC") == "0.5");
  CHECK(info.phases.back().second == "s + 60 <= elapsed <= s + 180");
  CHECK_THAT(info.instruction, Contains("exactly on step 120 of that count."));
  const auto batch = test::make_still(kId, {{"DELAY_STEPS", 120}});
  CHECK(*test::row<float>(batch->output("oracle_info"), 0) == 120);
}

TEST_CASE("A variant's own instruction stays as it is", "[variants][timed]") {
  const TaskVariant variant = {.id = "TimedTransferTold-v0",
                               .base = kId,
                               .constants = {{"DELAY_STEPS", 80}},
                               .instruction = "Wait exactly on step 5 of it."};
  register_variants({&variant, 1});
  CHECK(make_task(variant.id)->info().instruction == variant.instruction);
}

TEST_CASE("The signal comes when its range says", "[variants][timed]") {
  const MakeOptions options{{.num_envs = 300}, {{"PRE_SIGNAL_STEPS", ConstantList{30, 50}}}};
  const auto batch = test::make_running(kId, options);
  int least = 999;
  int most = 0;
  for (int i = 0; i < options.num_envs; ++i) {
    const int step = *test::row<std::int32_t>(test::memory_of(*batch).find("signal_step"), i);
    least = std::min(least, step);
    most = std::max(most, step);
  }
  CHECK((least == 30 && most == 50));
  CHECK(Queries(*batch).cue_end(0) == 50);
  CHECK(test::draw_of(batch->info(), "signal_step").low == 30);
  const ConstantTable narrow = {{"PRE_SIGNAL_STEPS", 33}};
  batch->reset({.mask = {}, .seeds = {}, .pins = nullptr, .constants = &narrow});
  CHECK(*test::row<std::int32_t>(test::memory_of(*batch).find("signal_step"), 5) == 33);
}

TEST_CASE("Discs are as large as their radius says", "[variants][timed]") {
  for (const double radius : {0.03, 0.05, 0.1}) {
    const auto task = make_task(kId, {{"DISC_RADIUS", radius}});
    for (const char* disc : {"green_disc", "red_disc"}) {
      CHECK(test::size_in(task->document(), disc) == radius);
    }
    CHECK(std::stod(test::constant_text(task->info(), "DISC_RADIUS")) == radius);
  }
}

TEST_CASE("A cube is on red as near as the threshold says", "[variants][timed]") {
  for (const double threshold : {0.01, 0.03, 0.1}) {
    const auto batch =
        test::make_still(kId, {{"GOAL_THRESH", threshold}},
                         {{"center_x", {-0.1}}, {"center_y", {0.0}}, {"signal_step", {1}}});
    const double* red = batch->state().prop_pos_of(0, kRedDisc);
    while (!flag(*batch, "in_window")) test::step(*batch, Policy::kZero);
    test::step_with(*batch, kCube, red[0] + threshold + 1e-6, red[1], 0.026);
    CHECK_FALSE(flag(*batch, "cube_on_red"));
    CHECK(test::succeeds_with(*batch, kCube, red[0] + threshold - 1e-6, red[1], 0.026));
    CHECK(batch->outputs().reward[0] == 30);
  }
}

TEST_CASE("Coefficients of TimedTransfer weigh the action cost", "[variants][timed]") {
  const auto reward = [](const ConstantTable& constants) {
    const auto batch = test::make_still(kId, constants, {{"signal_step", {1}}});
    std::vector<float> action = test::zeros(*batch);
    action[0] = 1;
    batch->step(action);
    return batch->outputs().reward[0];
  };
  CHECK(reward({{"ACTION_L2_COEF", 0.11}}) ==
        Approx(reward({}) - 0.1 * std::tanh(2.0)).margin(1e-6));
}

TEST_CASE("Delays that are too short to carry a cube, or end too late, are refused",
          "[variants][timed]") {
  CHECK_THROWS_WITH(make_task(kId, {{"DELAY_STEPS", 59}}), Contains("60 to"));
  CHECK_THROWS_WITH(make_task(kId, {{"DELAY_STEPS", 190}}),
                    Contains("3 + ") && Contains("199 + 1 to act = 203") && Contains("200"));
  CHECK_NOTHROW(make_task(kId, {{"DELAY_STEPS", 190}, {"max_episode_steps", 203}}));
  CHECK_THROWS_WITH(make_task(kId, {{"PRE_SIGNAL_STEPS", 95}}), Contains("201 control steps"));
  CHECK_THROWS_WITH(make_task(kId, {{"DISC_RADIUS", 0.12}}), Contains("0.03 to 0.1"));
}

}  // namespace
}  // namespace engram
