// RotateLenient and RotateStrict with other constants: what follows from each, and sets that are
// refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "tasks/rotate/peg_angle.h"
#include "tasks/rotate/task.h"
#include "tests/tasks/variants/constant_text.h"
#include "tests/tasks/variants/moved_props.h"

namespace engram {
namespace {

using Catch::Contains, test::make_running, test::row;

constexpr double kPi = std::numbers::pi;
constexpr const char* kLenient = "RotateLenientPos-VLA-v0";
constexpr const char* kStrict = "RotateStrictPosNeg-VLA-v0";
constexpr int kPeg = 0;

struct Targets {
  double least = 9;
  double most = -9;
};

Targets targets(const char* id, const ConstantTable& constants) {
  const MakeOptions options{{.num_envs = 1000}, constants};
  const auto batch = make_running(id, options);
  Targets seen;
  for (int i = 0; i < options.num_envs; ++i) {
    const double target = *row<double>(test::memory_of(*batch).find("target_angle"), i);
    seen.least = std::min(seen.least, target);
    seen.most = std::max(seen.most, target);
  }
  return seen;
}

TEST_CASE("The mode says on which sides targets lie", "[variants][rotate]") {
  const Targets both = targets(kLenient, {{"MODE", "pos_neg_angle"}});
  CHECK(both.least < -0.43);
  CHECK(both.most < kPi / 4 + 0.001);
  const Targets one = targets(kStrict, {{"MODE", "pos_angle"}});
  CHECK(one.least > 0.099);
  CHECK(one.most > 1.55);
  const auto task = make_task(kLenient, {{"MODE", "pos_neg_angle"}});
  CHECK(task->info().candidates == 4);
  CHECK(test::draw_of(task->info(), "target_angle").low == Approx(-kPi / 4));
  CHECK(test::constant_text(task->info(), "MODE") == "'pos_neg_angle'");
}

TEST_CASE("The threshold bounds targets from below, decides success and how lucky guesses are",
          "[variants][rotate]") {
  for (const double threshold : {0.05, 0.15, 0.3}) {
    const ConstantTable constants = {{"angle_threshold", threshold}};
    const Targets seen = targets(kLenient, constants);
    CHECK(seen.least == Approx(threshold).margin(0.01));
    CHECK(seen.most == Approx(kPi / 2).margin(0.01));
    const auto task = make_task(kLenient, constants);
    CHECK(test::draw_of(task->info(), "target_angle").low == threshold);
    const double guessed = tasks::guess_rate(tasks::RotateMode::kPosAngle, threshold);
    CHECK(task->info().candidates == std::lround(1 / guessed));

    const auto batch =
        test::make_still(kLenient, constants, {{"initial_yaw", {0.0}}, {"target_angle", {0.5}}});
    const auto turned = [&](double yaw) {
      double* quat = batch->state().prop_quat_of(0, kPeg);
      quat[0] = std::cos(yaw / 2);
      quat[3] = std::sin(yaw / 2);
      test::step(*batch, Policy::kZero);
      return batch->outputs().success[0] != 0;
    };
    CHECK(turned(0.5 - threshold + 1e-6));
    CHECK(batch->outputs().reward[0] == 60);
    CHECK_FALSE(turned(0.5 - threshold - 1e-6));
    CHECK(batch->outputs().reward[0] < 60);
    CHECK_FALSE(turned(0.5 + threshold + 1e-6));
  }
}

TEST_CASE("The rate of lucky guesses is that of targets drawn twice", "[variants][rotate]") {
  for (const auto mode : {tasks::RotateMode::kPosAngle, tasks::RotateMode::kPosNegAngle}) {
    for (const double least : {0.05, 0.1, 0.3}) {
      constexpr int kGrid = 300;
      int right = 0;
      for (int i = 0; i < kGrid * kGrid; ++i) {
        const double one = tasks::target_angle(mode, least, (i % kGrid + 0.5) / kGrid);
        const double other = tasks::target_angle(mode, least, (i / kGrid + 0.5) / kGrid);
        right += std::abs(one - other) < least ? 1 : 0;
      }
      CHECK(tasks::guess_rate(mode, least) == Approx(right / double{kGrid * kGrid}).margin(0.005));
    }
  }
}

TEST_CASE("The threshold counts in both rewards", "[variants][rotate]") {
  tasks::RotateReward in{.error = 0.2};
  const double lenient = in.compute();
  in.strict = true;
  const double strict = in.compute();
  in.angle_threshold = 0.25;
  CHECK(in.compute() == Approx(strict + 10));
  in.strict = false;
  CHECK(in.compute() == Approx(lenient + 5));
}

TEST_CASE("The peg is as large and as heavy as its sizes say", "[variants][rotate]") {
  for (const char* id : {kLenient, kStrict}) {
    for (const auto& [width, length] : {std::pair(0.015, 0.06), std::pair(0.03, 0.18)}) {
      const ConstantTable constants = {{"PEG_HALF_WIDTH", width}, {"PEG_HALF_LENGTH", length}};
      const auto task = make_task(id, constants);
      CHECK(test::size_in(task->document(), "peg") == length);
      CHECK(test::mass_in(task->document(), "peg") == Approx(8000 * width * width * length));
      CHECK(test::make_still(id, constants)->state().prop_pos_of(0, kPeg)[2] == width);
      CHECK(std::stod(test::constant_text(task->info(), "PEG_HALF_WIDTH")) == width);
      CHECK(std::stod(test::constant_text(task->info(), "PEG_HALF_LENGTH")) == length);
    }
  }
}

TEST_CASE("Coefficients make abrupt actions cost in both Rotate families", "[variants][rotate]") {
  for (const char* id : {kLenient, kStrict}) {
    CHECK(test::dense_reward_of(id, {{"ACTION_L2_COEF", 0.1}}) ==
          Approx(test::dense_reward_of(id, {}) - 0.1 * std::tanh(2.0)).margin(1e-6));
  }
}

TEST_CASE("Pegs that cannot be turned, and no time for it, are refused", "[variants][rotate]") {
  CHECK_THROWS_WITH(make_task(kLenient, {{"PEG_HALF_LENGTH", 0.06}, {"PEG_HALF_WIDTH", 0.035}}),
                    Contains("PEG_HALF_LENGTH") && Contains("0.07"));
  CHECK_NOTHROW(make_task(kLenient, {{"PEG_HALF_WIDTH", 0.035}}));
  // The hand has to reach round it.
  CHECK_THROWS_WITH(make_task(kStrict, {{"PEG_HALF_WIDTH", 0.035}}), Contains("0.015 to 0.03"));
  CHECK_THROWS_WITH(make_task(kStrict, {{"MODE", "neg_angle"}}), Contains("pos_angle"));
  CHECK_THROWS_WITH(make_task(kStrict, {{"angle_threshold", 1}}), Contains("0.05 to 0.3"));
  CHECK_THROWS_WITH(make_task(kStrict, {{"max_episode_steps", 10}}), Contains("25 to act"));
}

}  // namespace
}  // namespace engram
