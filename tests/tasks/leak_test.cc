// No later image may reveal the content of the cue: else memory would not be needed.
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "core/batch/snapshot.h"
#include "tasks/family_samples.h"
#include "tests/tasks/leak_check.h"

namespace engram {
namespace {

using test::ImagePair;

constexpr std::uint64_t kEpisodes = 2;  // of long tasks: one

void check_all(Policy policy) {
  for (const std::string& id : test::implemented_ids()) {
    const std::uint64_t episodes = require_entry(id).horizon > 100 ? 1 : kEpisodes;
    for (std::uint64_t seed = 0; seed < episodes; ++seed) {
      INFO(id << ", seed " << seed << ", " << name_of(policy));
      test::check_leaks(id, {}, seed, {.policy = policy});
    }
  }
}

TEST_CASE("No image of short episodes after the cue reveals what was shown", "[render][leak]") {
  constexpr std::array kPolicies = {Policy::kSweep, Policy::kRandom, Policy::kZero};
  std::size_t turn = 0;
  for (const std::string& id : short_ids()) {
    const Policy policy = kPolicies[turn++ % kPolicies.size()];
    INFO(id << ", " << name_of(policy));
    test::check_leaks(id, {}, 0, {.policy = policy});
  }
}

TEST_CASE("No image after the cue reveals what was shown under perturbations",
          "[render][leak][perturbation]") {
  std::vector<PerturbationLevel> levels;
  for (std::size_t i = 0; i < kPerturbationAxes; ++i) {
    const auto axis = static_cast<PerturbationAxis>(i);
    // A wide post would hide cues.
    levels.push_back({axis, axis == PerturbationAxis::kOccluder ? 0.25 : 1});
  }
  for (const std::string& id : short_ids()) {
    INFO(id);
    // All steps after the cue are looked at without perturbations, above.
    test::check_leaks(id, {}, 1,
                      {.closely = 20, .policy = Policy::kSweep, .perturbations = levels});
  }
}

TEST_CASE("No image after the cue reveals what was shown to a robot that rests",
          "[render][leak][long]") {
  check_all(Policy::kZero);
}

TEST_CASE("No image after the cue reveals what was shown to a robot that moves about",
          "[render][leak][long]") {
  check_all(Policy::kRandom);
}

TEST_CASE("No image after the cue reveals what was shown to a robot that does the task",
          "[render][leak][long]") {
  check_all(Policy::kSweep);
}

// Their hidden draws are said to show at no set time, or never.
TEST_CASE("The families that hide nothing behind a cue are those that are tested here",
          "[render][leak]") {
  for (const std::string& id : test::implemented_ids()) {
    INFO(id);
    const bool here = id.find("Rotate") == 0 || id.find("TakeItBack") == 0;
    const bool open = id.find("Intercept") == 0;  // nothing is hidden at all
    CHECK(make_task(id)->info().hidden_variable.empty() == (here || open));
  }
}

TEST_CASE("Images of Rotate never reveal the angle", "[render][leak]") {
  for (const std::string& id : test::implemented_ids()) {
    if (id.find("Rotate") != 0) continue;
    INFO(id);
    const std::unique_ptr<Task> task = make_task(id);
    const RandomVariable draw = *test::draw_named(task->info(), "target_angle");
    const auto one = test::make_hiding(id, {}, 3, draw, false);
    const auto other = test::make_hiding(id, {}, 3, draw, true);
    ImagePair images(*one, *other);
    for (int t = 0; t < 60; ++t) {
      for (const char* camera : {"base_camera", "hand_camera", "render_camera"}) {
        REQUIRE(images.differing_pixels(camera) == 0);
      }
      const std::vector<float> actions = test::act(*one, Policy::kSweep);
      one->step(actions);
      other->step(actions);
      // An RL episode ends at its success.
      if ((one->state().finished[0] | other->state().finished[0]) != 0) break;
    }
  }
}

// The cube shows where it started until it is moved. From the target on, nothing does: with another
// start in the environment's memory, and the same robot, images are the same.
TEST_CASE("Images of TakeItBack do not reveal the start once the cube is on its target",
          "[render][leak]") {
  const std::string id = GENERATE(as<std::string>{}, "TakeItBack-VLA-v0", "TakeItBack-v0");
  BatchOptions options{.threads = 1, .auto_reset = AutoReset::kOff};
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    options.seed = seed;
    const auto one = make(id, options);
    const auto other = make(id, options);
    one->reset();
    other->reset();
    while (*test::row<std::uint8_t>(one->output("goal_reached_status"), 0) == 0) {
      test::step(*one, Policy::kOracle);
    }
    Snapshotter(*other).restore(Snapshotter(*one).save());
    // What the robot has to remember.
    auto* start = reinterpret_cast<double*>(test::memory_of(*other).find("initial").row(0));
    start[0] = -start[0];
    start[1] = -start[1] - 0.05;
    ImagePair images(*one, *other);
    for (int t = 0; t < 15; ++t) {
      const std::vector<float> actions = test::act(*one, Policy::kRandom);
      one->step(actions);
      other->step(actions);
      for (const char* sensor : {"base_camera", "hand_camera"}) {
        REQUIRE(images.differing_pixels(sensor) == 0);
      }
    }
  }
}

}  // namespace
}  // namespace engram
