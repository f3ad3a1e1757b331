// No later depth or segmentation may reveal the content of the cue: not by the order in
// which segments are counted either.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <string>
#include <vector>

#include "tasks/family_samples.h"
#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

constexpr int kSide = 64;

std::unique_ptr<Batch> make_seeing(const std::string& id, std::uint64_t seed,
                                   const RandomVariable& draw, bool second) {
  BatchOptions options{.seed = seed,
                       .threads = 1,
                       .obs_mode = ObsMode::kRgbDepthSegmentation,
                       .auto_reset = AutoReset::kOff};
  options.images.width = options.images.height = kSide;
  options.reward_mode = RewardMode::kSparse;  // dense ones measure the way to the hidden goal
  options.pins = {{draw.name, test::hidden_values(draw, second)}};
  auto batch = make(id, options);
  batch->reset();
  return batch;
}

struct Count {
  int steps = 0;      // that were compared
  int uncovered = 0;  // others after the cue, in which colours show what the robot has uncovered
  int shown = 0;      // steps of the cue in which colours show it
  int shaped = 0;     // and those in which depth or segmentation do
};

bool same_cells(const Batch& one, const Batch& other) {
  return std::ranges::equal(one.images().depth, other.images().depth) &&
         std::ranges::equal(one.images().segmentation, other.images().segmentation);
}

void compare(Batch& one, Batch& other, Policy policy, Count& count) {
  test::play_unanswered(one, other, policy, [&](bool shown) {
    if (shown) {
      count.shown += std::ranges::equal(one.images().rgb, other.images().rgb) ? 0 : 1;
      count.shaped += same_cells(one, other) ? 0 : 1;
    } else if (!std::ranges::equal(one.images().rgb, other.images().rgb)) {
      ++count.uncovered;
    } else {
      REQUIRE(std::ranges::equal(one.images().depth, other.images().depth));
      REQUIRE(std::ranges::equal(one.images().segmentation, other.images().segmentation));
      ++count.steps;
    }
  });
}

Count check(const std::string& id, Policy policy, std::uint64_t seed) {
  Count count;
  const TaskInfo info = make_task(id)->info();
  const std::optional<RandomVariable> draw = test::draw_named(info, info.hidden_variable);
  if (!draw) return count;
  INFO(id << ", seed " << seed << ", " << name_of(policy));
  compare(*make_seeing(id, seed, *draw, false), *make_seeing(id, seed, *draw, true), policy, count);
  // A robot that moves about knocks cups over.
  const bool may_uncover = policy == Policy::kRandom && id.starts_with("ShellGame");
  if (!may_uncover) CHECK(count.uncovered == 0);
  return count;
}

TEST_CASE("Depth and segmentation of short episodes reveal nothing after the cue",
          "[render][leak][depth]") {
  int steps = 0;
  for (const std::string& id : short_ids()) {
    steps += check(id, Policy::kSweep, 0).steps;
  }
  CHECK(steps > 300);
}

TEST_CASE("Depth and segmentation reveal nothing after the cue", "[render][leak][depth][long]") {
  const Policy policy = GENERATE(Policy::kZero, Policy::kRandom, Policy::kSweep);
  int tasks = 0;
  int steps = 0;
  int uncovered = 0;
  for (const std::string& id : test::implemented_ids()) {
    for (std::uint64_t seed = 0; seed < (require_entry(id).horizon > 100 ? 1 : 2); ++seed) {
      const Count count = check(id, policy, seed);
      steps += count.steps;
      uncovered += count.uncovered;
      tasks += seed == 0 && count.steps + count.shown > 0 ? 1 : 0;
    }
  }
  std::printf("depth and segmentation, %s: %d tasks, %d steps compared\n", name_of(policy), tasks,
              steps);
  CHECK(tasks == 107);
  CHECK(uncovered < 50);
  // Sweeps end episodes at their success.
  CHECK(steps > (policy == Policy::kSweep ? 20000 : 50000));
}

// Where one thing changes its colour, its shape and its name stay.
TEST_CASE("A cue of colour alone shows in colours alone", "[render][leak][depth]") {
  for (const std::string& id : test::implemented_ids()) {
    if (!id.starts_with("TimedTransfer") && !id.starts_with("BlinkCount")) continue;
    INFO(id);
    const Count count = check(id, Policy::kZero, 1);
    CHECK(count.shown > 0);
    CHECK(count.shaped == 0);
  }
}

TEST_CASE("Depth and segmentation of Rotate never reveal the angle", "[render][leak][depth]") {
  for (const std::string& id : test::implemented_ids()) {
    if (id.find("Rotate") != 0) continue;
    INFO(id);
    const RandomVariable draw = *test::draw_named(make_task(id)->info(), "target_angle");
    const auto one = make_seeing(id, 3, draw, false);
    const auto other = make_seeing(id, 3, draw, true);
    for (int t = 0; t < 30; ++t) {
      REQUIRE(same_cells(*one, *other));
      const std::vector<float> actions = test::act(*one, Policy::kSweep);
      one->step(actions);
      other->step(actions);
      // An RL episode ends at its success.
      if ((one->state().finished[0] | other->state().finished[0]) != 0) break;
    }
  }
}

}  // namespace
}  // namespace engram
