// TimedTransfer as its users see it, and snapshots of the tracing and transferring tasks.
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <vector>

#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::Bytes, test::make_env, test::make_running, test::row;

constexpr int kCube = 2;
constexpr int kBulb = 4;

template <class T>
T info(const Batch& batch, const char* name, int index = 0) {
  return *row<T>(batch.output(name), index);
}

BatchOptions signal_at(double step) {
  BatchOptions options{.reward_mode = RewardMode::kDense,
                       .auto_reset = AutoReset::kOff,
                       .pins = {{"signal_step", {step}}}};
  return options;
}

TEST_CASE("Doing nothing fails one step after the window: D = 100, s = 2", "[timed]") {
  const auto batch = make_running("TimedTransferEasy-VLA-v0", signal_at(2));
  CHECK(batch->state_dim() == 50);
  CHECK(Queries(*batch).instruction(0).find("step 100 of") != std::string::npos);
  const std::vector<float> rest = test::zeros(*batch);
  for (int elapsed = 0; elapsed <= 108; ++elapsed) {
    INFO(elapsed);
    CHECK(batch->state().elapsed[0] == elapsed);
    CHECK(info<std::uint8_t>(*batch, "signal_on") == (elapsed >= 2 ? 1 : 0));
    CHECK(batch->state().prop_rgba.row(0)[4 * kBulb + 1] == (elapsed >= 2 ? 1 : 220 / 255.0F));
    CHECK(info<std::uint8_t>(*batch, "in_window") == (elapsed >= 97 && elapsed <= 107 ? 1 : 0));
    CHECK(info<std::uint8_t>(*batch, "failed") == (elapsed >= 108 ? 1 : 0));
    CHECK(batch->outputs().terminated[0] == (elapsed >= 108 ? 1 : 0));
    CHECK(info<float>(*batch, "oracle_info") == 100);
    if (elapsed == 1) CHECK(batch->outputs().reward[0] == 0);
    if (elapsed < 108) batch->step(rest);
  }
  CHECK(batch->outputs().reward[0] == -25);
  CHECK(info<std::uint8_t>(*batch, "too_early") == 0);
  CHECK(info<std::uint8_t>(*batch, "answered") == 0);
  CHECK(batch->state().prop_pos_of(0, kCube)[2] == Approx(0.026).margin(2e-4));
}

TEST_CASE("The cube arrives in the window and ends the episode", "[timed]") {
  const auto batch = make_running("TimedTransferEasy-VLA-v0", signal_at(1));
  while (batch->state().finished[0] == 0) {
    const bool before = info<std::uint8_t>(*batch, "before_window") != 0;
    test::step(*batch, Policy::kOracle);
    if (before) CHECK(info<std::uint8_t>(*batch, "cube_on_red") == 0);
  }
  CHECK(info<std::uint8_t>(*batch, "success") == 1);
  CHECK(info<std::uint8_t>(*batch, "in_window") == 1);
  CHECK(info<std::uint8_t>(*batch, "is_grasped") == 1);
  CHECK(batch->outputs().terminated[0] == 1);
  CHECK(batch->outputs().reward[0] == 30);
  CHECK(info<std::uint8_t>(*batch, "first_answer_correct") == 1);
  CHECK(info<std::int32_t>(*batch, "first_answer") == batch->state().elapsed[0] - 1);
}

// Puts the cube on the red disc before step `elapsed`, and goes on to there.
std::unique_ptr<Batch> put_on_red(int elapsed, double signal) {
  constexpr int kRedDisc = 1;
  auto batch = make_running("TimedTransferEasy-VLA-v0", signal_at(signal));
  while (batch->state().elapsed[0] < elapsed - 1) batch->step(test::zeros(*batch));
  const double upright[4] = {1, 0, 0, 0};
  const double* red = batch->state().prop_pos_of(0, kRedDisc);
  const double place[3] = {red[0], red[1], batch->state().prop_pos_of(0, kCube)[2]};
  batch->state().place_prop(0, kCube, place, upright);
  batch->step(test::zeros(*batch));
  return batch;
}

TEST_CASE("The answer is the step in which the cube comes to red", "[timed][answer]") {
  for (const int step : {0, 1, 50, 94, 95, 100, 105}) {
    INFO(step);
    const auto batch = put_on_red(2 + step, 2);
    CHECK(info<std::uint8_t>(*batch, "answered") == 1);
    CHECK(info<std::int32_t>(*batch, "first_answer") == step);
    CHECK(info<std::uint8_t>(*batch, "first_answer_correct") == (step >= 95 ? 1 : 0));
    CHECK(info<std::uint8_t>(*batch, "success") == (step >= 95 ? 1 : 0));
  }
  // Before the signal there is no count.
  const auto early = put_on_red(1, 3);
  CHECK(info<std::uint8_t>(*early, "cube_on_red") == 1);
  CHECK(info<std::uint8_t>(*early, "answered") == 0);
}

TEST_CASE("Who has the step count need not remember the signal", "[timed]") {
  for (const double signal : {1, 2, 3}) {
    const auto batch = make_running("TimedTransferEasy-VLA-v0", signal_at(signal));
    while (batch->state().finished[0] == 0) test::step(*batch, Policy::kSweep);
    CHECK(info<std::uint8_t>(*batch, "success") == 1);
  }
}

// The first and the last step of the count at which the cube may arrive.
std::pair<int, int> window(const char* id, Rules rules) {
  BatchOptions options = signal_at(2);
  options.rules = rules;
  const auto batch = make_running(id, options);
  std::pair<int, int> steps = {0, 0};
  while (info<std::uint8_t>(*batch, "past_window") == 0) {
    batch->step(test::zeros(*batch));
    if (info<std::uint8_t>(*batch, "in_window") == 0) continue;
    const int count = batch->state().elapsed[0] - 2;
    if (steps.first == 0) steps.first = count;
    steps.second = count;
  }
  return steps;
}

TEST_CASE("The tolerance is five per cent of 150 steps, in the original's code more", "[timed]") {
  constexpr const char* kMedium = "TimedTransferMedium-VLA-v0";
  CHECK(window(kMedium, Rules::kReference) == std::pair(143, 157));
  CHECK(window(kMedium, Rules::kOriginal) == std::pair(142, 157));
}

TEST_CASE("Chance and phases are those of the window", "[timed]") {
  for (const Rules rules : {Rules::kReference, Rules::kOriginal}) {
    const auto batch = make_env("TimedTransferMedium-VLA-v0", {.rules = rules});
    const bool original = rules == Rules::kOriginal;
    CHECK(batch->info().chance() == Approx((original ? 16.0 : 15.0) / 301));
    CHECK(batch->info().answer_chance() == batch->info().chance());
    CHECK(batch->info().phases.back().second ==
          (original ? "s + 142 <= elapsed <= s + 157" : "s + 143 <= elapsed <= s + 157"));
  }
}

TEST_CASE("Oracle and sweep bring the cube in the window of either rules", "[timed]") {
  for (const Rules rules : {Rules::kReference, Rules::kOriginal}) {
    for (const Policy policy : {Policy::kOracle, Policy::kSweep}) {
      BatchOptions options = signal_at(3);
      options.rules = rules;
      const auto batch = make_running("TimedTransferMedium-VLA-v0", options);
      while (batch->state().finished[0] == 0) test::step(*batch, policy);
      CHECK(info<std::uint8_t>(*batch, "success") == 1);
    }
  }
}

TEST_CASE("A cube that arrives early fails at once", "[timed]") {
  BatchOptions options = signal_at(3);
  options.num_envs = 20;
  const auto batch = make_running("TimedTransferMedium-VLA-v0", options);
  int early = 0;
  for (int i = 0; i < 120; ++i) {
    test::step(*batch, Policy::kBlind);
    for (int k = 0; k < options.num_envs; ++k) {
      if (info<std::uint8_t>(*batch, "too_early", k) == 0) continue;
      ++early;
      REQUIRE(info<std::uint8_t>(*batch, "failed", k) == 1);
      REQUIRE(info<std::uint8_t>(*batch, "success", k) == 0);
      REQUIRE(batch->outputs().terminated[static_cast<std::size_t>(k)] == 1);
    }
  }
  CHECK(early > 0);
}

// What one environment shows and remembers over the next steps.
std::vector<Bytes> future(Batch& batch, int index, int steps) {
  std::vector<Bytes> history;
  for (int i = 0; i < steps; ++i) {
    test::step(batch, Policy::kOracle);
    history.push_back(test::env_bytes(batch, index));
  }
  return history;
}

TEST_CASE("Snapshots in a demonstration and in a grasp go on bit for bit", "[snapshot]") {
  for (const char* id :
       {"TraceShapeHard-VLA-v0", "TraceShapeSeqHard-VLA-v0", "TimedTransferEasy-VLA-v0"}) {
    BatchOptions options{.num_envs = 2, .threads = 1};
    if (std::string(id).find("Seq") != std::string::npos) {
      options.pins = {{"sequence_length", {2}}};
    }
    const auto batch = make_running(id, options);
    bool held = false;
    for (int round = 0; round < 12; ++round) {
      for (int i = 0; i < 16; ++i) test::step(*batch, Policy::kOracle);
      const int cube = std::string(id)[1] == 'i' ? kCube : 1;
      held |= is_grasping(batch->state(), 0, cube);
      const std::vector<std::byte> saved = Snapshotter(*batch).save(0);
      const std::vector<Bytes> expected = future(*batch, 0, 8);
      INFO(id << ", round " << round);
      const auto other = make_running(id, options);
      Snapshotter(*other).restore(1, saved);
      CHECK((future(*other, 1, 8) == expected));
      Snapshotter(*batch).restore(0, saved);
    }
    CHECK(held);
  }
}

}  // namespace
}  // namespace engram
