// The cup that the robot first touches or moves is its answer; answers from the lamp alone.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/tasks/first_answer.h"
#include "tests/tasks/pose_tool.h"
#include "tests/tasks/shell_game/ids.h"

namespace engram {
namespace {

using Eigen::Vector3d, test::first_answer, test::FirstAnswer, test::make_env, test::make_running,
    test::row, test::step_at;
using namespace test::shell_game;

const Vector3d kOver(0, 0, 0.075);  // m: a touch, from a cup's origin
const Vector3d kAway(-0.1, 0, 0.4);

// Everything stays where a test puts it, and the robot may act from the second step on.
BatchOptions still(std::vector<Pin> pins, bool strict = false) {
  BatchOptions options{.auto_reset = AutoReset::kOff,
                       .terminate_on_success = false,
                       .substeps = 0,
                       .pins = std::move(pins)};
  options.pins.push_back({"cue_steps", {2}});
  options.pins.push_back({"base", {0, 0}});
  options.task_options = {{kStrictOption, strict ? 1.0 : 0.0}};
  return options;
}

std::unique_ptr<Batch> make(const char* id, std::vector<Pin> pins, bool strict = false,
                            Rules rules = Rules::kReference) {
  BatchOptions options = still(std::move(pins), strict);
  options.rules = rules;
  return make_running(id, options);
}

Vector3d slot(int place) { return {0, 0.2 * (place - 1), 0.0529462}; }
void move(const Batch& batch, int cup, const Vector3d& way) {
  const Vector3d there = slot(cup) + way;
  std::copy_n(there.data(), 3, batch.state().prop_pos_of(0, cup));
}
// Goes on until the robot may act.
void wait(Batch& batch) {
  const int start = *row<std::int32_t>(test::memory_of(batch).find("manipulation_start"), 0);
  while (batch.state().elapsed[0] < start) step_at(batch, kAway);
}
bool succeeds(const Batch& batch) { return batch.outputs().success[0] != 0; }
bool failed(const Batch& batch) { return *row<std::uint8_t>(batch.output("failed"), 0) != 0; }

TEST_CASE("The cup at which the robot first rests is its answer", "[shell][answer]") {
  for (const bool strict : {false, true}) {
    const auto batch = make(kTouch, {{"cup_with_ball_number", {1}}}, strict);
    step_at(*batch, slot(1) + kOver);  // still the cue
    CHECK(first_answer(*batch) == FirstAnswer{});
    step_at(*batch, kAway);
    test::pose_tool(*batch, slot(0) + kOver);
    batch->state().qvel.row(0)[0] = 0.21;  // in passing
    test::step(*batch, Policy::kZero);
    CHECK(first_answer(*batch) == FirstAnswer{});
    step_at(*batch, slot(2) + kOver + Vector3d(0.05, 0, 0));
    CHECK(first_answer(*batch) == FirstAnswer{});
    step_at(*batch, slot(2) + kOver);
    CHECK(first_answer(*batch) == FirstAnswer{true, 2, false});
    CHECK(failed(*batch) == strict);
    step_at(*batch, slot(1) + kOver);
    CHECK(first_answer(*batch) == FirstAnswer{true, 2, false});
    CHECK(succeeds(*batch) == !strict);
  }
}

TEST_CASE("A right cup is a right answer, whatever follows", "[shell][answer]") {
  const auto batch = make(kTouch, {{"cup_with_ball_number", {0}}}, true);
  wait(*batch);
  step_at(*batch, slot(0) + kOver);
  CHECK(first_answer(*batch) == FirstAnswer{true, 0, true});
  CHECK(succeeds(*batch));
  step_at(*batch, slot(1) + kOver);
  CHECK(first_answer(*batch) == FirstAnswer{true, 0, true});
  CHECK_FALSE(failed(*batch));
}

TEST_CASE("A cup that is moved is an answer", "[shell][answer]") {
  struct Moved {
    const char* id;
    double least;  // m
    Rules rules = Rules::kReference;
  };
  // The original's: half the least way of Push, 0.1000 - 0.096 m, and of Pick, 0.0921 - 0.08 m.
  for (const auto& [id, least, rules] : {Moved{kTouch, 0.01},
                                         {kPush, 0.004},
                                         {kPick, 0.004},
                                         {kPush, 0.002022, Rules::kOriginal},
                                         {kPick, 0.006027, Rules::kOriginal}}) {
    for (const Vector3d& way : {Vector3d(1, 0, 0), Vector3d(0, -1, 0), Vector3d(0, 0, 1)}) {
      INFO(id << ", " << way.transpose());
      const auto batch = make(id, {{"cup_with_ball_number", {2}}}, false, rules);
      wait(*batch);
      move(*batch, 0, (least - 2e-5) * way);
      step_at(*batch, kAway);
      CHECK(first_answer(*batch) == FirstAnswer{});
      move(*batch, 0, (least + 2e-5) * way);
      step_at(*batch, kAway);
      CHECK(first_answer(*batch) == FirstAnswer{true, 0, false});
      move(*batch, 2, 0.04 * way);
      step_at(*batch, kAway);
      CHECK(first_answer(*batch) == FirstAnswer{true, 0, false});
    }
    const auto batch = make(id, {{"cup_with_ball_number", {2}}}, false, rules);
    wait(*batch);
    move(*batch, 0, {0.012, 0, 0});
    move(*batch, 2, {0.013, 0, 0});  // the farther of two
    step_at(*batch, kAway);
    CHECK(first_answer(*batch) == FirstAnswer{true, 2, true});
  }
}

TEST_CASE("After a shuffle answers are slots", "[shell][answer]") {
  // The cup of slot 0 ends in slot 2.
  const std::vector<Pin> shuffle = {
      {"shuffle_steps", {20}}, {"num_swaps", {2}}, {"swap_pairs", {0, 2, 0, 0}}};
  for (const bool lamp : {false, true}) {
    std::vector<Pin> pins = shuffle;
    pins.push_back({lamp ? "target_color" : "cup_with_ball_number", {0}});
    if (lamp) pins.push_back({"mapping", {0}});
    for (int place = 0; place < 3; ++place) {
      const auto batch = make(lamp ? kShuffleLamp : kShuffle, pins);
      while (batch->state().elapsed[0] < 21) step_at(*batch, slot(place) + kOver);
      CHECK(first_answer(*batch) == FirstAnswer{});
      step_at(*batch, slot(place) + kOver);
      CHECK(first_answer(*batch) == FirstAnswer{true, place, place == 2});
      CHECK(succeeds(*batch) == (place == 2));
    }
  }
}

TEST_CASE("A pinned mapping is obeyed under fixed_mapping, too", "[shell][lamp]") {
  for (const char* id : {kLamp, kShuffleLamp}) {
    for (const bool fixed : {false, true}) {
      const auto batch = make_env(
          id, {.pins = {{"mapping", {3}}}, .task_options = {{"fixed_mapping", fixed ? 1.0 : 0.0}}});
      const auto slots = [&] {
        const std::uint8_t* drawn =
            row<std::uint8_t>(test::memory_of(*batch).find("slot_of_color"), 0);
        return std::vector<int>(drawn, drawn + 3);
      };
      INFO(id << ", fixed " << fixed);
      batch->reset();
      CHECK(slots() == std::vector<int>{1, 2, 0});
      const std::vector<Pin> none;
      ResetRequest unpinned;
      unpinned.pins = &none;
      batch->reset(unpinned);
      if (fixed) CHECK(slots() == std::vector<int>{0, 1, 2});
    }
  }
}

TEST_CASE("With a fixed mapping the lamp alone reveals the cup, unless cups are shuffled",
          "[shell][lamp]") {
  constexpr int kEpisodes = 60;
  for (const bool shuffled : {false, true}) {
    const auto batch = make_env(shuffled ? kShuffleLamp : kLamp,
                                {.num_envs = kEpisodes,
                                 .auto_reset = AutoReset::kOff,
                                 .task_options = {{"fixed_mapping", 1}, {kStrictOption, 1}}});
    const double chance = shuffled ? 1.0 / 3 : 1.0;
    CHECK(batch->info().chance() == Approx(chance));
    CHECK(batch->info().answer_chance() == Approx(chance));
    for (const Policy policy : {Policy::kBlind, Policy::kSweep}) {
      batch->reset();
      for (int t = 0; t < batch->info().horizon; ++t) test::step(*batch, policy);
      int successes = 0;
      for (int i = 0; i < kEpisodes; ++i) {
        successes += *row<std::uint8_t>(batch->output("success_once"), i);
      }
      INFO(name_of(policy) << ", shuffled " << shuffled);
      CHECK(successes / double{kEpisodes} == Approx(chance).margin(shuffled ? 0.2 : 0));
    }
  }
  CHECK(make_env(kLamp)->info().chance() == Approx(1.0 / 3));
}

}  // namespace
}  // namespace engram
