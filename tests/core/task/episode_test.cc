// Random variables of episodes: pins, narrower ranges, refusals.
#include "core/task/episode.h"

#include <catch2/catch.hpp>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/batch/queries.h"
#include "core/batch/snapshot.h"
#include "tests/env_helpers.h"

namespace engram {
namespace {

using test::make_env, test::make_running, test::row;

constexpr const char* kId = "RememberColor5-VLA-v0";

// What an episode of RememberColor draws, by draw.
struct Drawn {
  std::vector<double> noise;
  int target = 0;
  std::vector<double> positions;
  int cue = 0;
  int empty = 0;

  bool operator==(const Drawn&) const = default;
};

Drawn drawn(const Batch& batch, int index) {
  const ColumnStore& memory = test::memory_of(batch);
  const double* qpos = row<double>(memory.find("qpos"), index);
  const double* positions = row<double>(memory.find("positions"), index);
  return {std::vector<double>(qpos, qpos + 7), *row<std::int32_t>(memory.find("target"), index),
          std::vector<double>(positions, positions + 15),
          *row<std::int32_t>(memory.find("cue_steps"), index),
          *row<std::int32_t>(memory.find("empty_steps"), index)};
}

Drawn drawn_with(const std::vector<Pin>& pins, std::uint64_t seed = 3) {
  const auto batch = make_running(kId, {.seed = seed, .pins = pins});
  return drawn(*batch, 0);
}

const std::vector<double> kPositions = {0, 0, 0.1, 0, 0.2, 0, 0, 0.1, 0.1, 0.1};

TEST_CASE("Each draw can be fixed and all others stay as they were", "[pins]") {
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const Drawn free = drawn_with({}, seed);
    Drawn expected = free;
    expected.target = 4;
    CHECK(drawn_with({{"target", {4}}}, seed) == expected);
    expected = free;
    expected.cue = 5;
    CHECK(drawn_with({{"cue_steps", {5}}}, seed) == expected);
    expected = free;
    expected.empty = 1;
    CHECK(drawn_with({{"empty_steps", {1}}}, seed) == expected);
    expected = free;
    expected.positions = {0, 0, 0.02, 0.1, 0, 0.02, 0.2, 0, 0.02, 0, 0.1, 0.02, 0.1, 0.1, 0.02};
    CHECK(drawn_with({{"positions", kPositions}}, seed) == expected);
    expected = free;
    expected.noise = {0, 0, 0, -2.0943951023931953, 0, 2.0943951023931953, 0.7853981633974483};
    const Drawn quiet = drawn_with({{"robot_noise", {0, 0, 0, 0, 0, 0, 0}}}, seed);
    for (std::size_t i = 0; i < 7; ++i) CHECK(quiet.noise[i] == Approx(expected.noise[i]));
    expected.noise = quiet.noise;
    CHECK(quiet == expected);
  }
}

TEST_CASE("Draws are described with the engine's own first", "[pins]") {
  const auto batch = make_env(kId);
  std::vector<std::string> names;
  for (const RandomVariable& draw : Queries(*batch).random_variables()) names.push_back(draw.name);
  CHECK(names ==
        std::vector<std::string>{"robot_noise", "target", "positions", "cue_steps", "empty_steps"});
  CHECK(Queries(*batch).random_variables()[1].integer);
  CHECK(Queries(*batch).random_variables()[1].low == 0);
  CHECK(Queries(*batch).random_variables()[1].high == 4);
  CHECK(Queries(*batch).random_variables()[2].width == 10);
}

TEST_CASE("Pins last over automatic resets until they are replaced", "[pins]") {
  const auto batch = make_running(kId, {.num_envs = 2, .pins = {{"target", {2}}}});
  const auto targets_of = [&](int episodes) {
    std::set<int> targets;
    for (int i = 0; i < episodes; ++i) {
      batch->reset();
      targets.insert(drawn(*batch, 0).target);
    }
    return targets;
  };
  for (int i = 0; i < 60; ++i) {  // two automatic resets
    test::step(*batch, Policy::kZero);
    REQUIRE(drawn(*batch, 0).target == 2);
  }
  CHECK(targets_of(10) == std::set{2});

  // Replaced in one environment only.
  const std::vector<Pin> other = {{"target", {1}}};
  const std::uint8_t mask[] = {1, 0};
  ResetRequest request;
  request.mask = mask;
  request.pins = &other;
  batch->reset(request);
  CHECK(drawn(*batch, 0).target == 1);
  batch->reset();
  CHECK(drawn(*batch, 0).target == 1);
  CHECK(drawn(*batch, 1).target == 2);

  const std::vector<Pin> none;
  ResetRequest clear;
  clear.pins = &none;
  batch->reset(clear);
  CHECK(targets_of(30).size() > 2);
}

TEST_CASE("Pins that are not allowed are refused and change nothing", "[pins]") {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  struct Case {
    std::vector<Pin> pins;
    const char* message;
  };
  const Case cases[] = {
      {{{"targets", {1}}}, "no draw named 'targets'"},
      {{{"target", {5}}}, "value 5 given, a whole number from 0 to 4 allowed"},
      {{{"target", {-1}}}, "value -1 given"},
      {{{"target", {1.5}}}, "value 1.5 given"},
      {{{"target", {kNan}}}, "nan given"},
      {{{"target", {}}}, "0 values given, 1 needed"},
      {{{"target", {1, 2}}}, "2 values given, 1 needed"},
      {{{"target", {1}}, {"target", {2}}}, "given twice"},
      {{{"cue_steps", {0}}}, "from 1 to 5 allowed"},
      {{{"cue_steps", {6}}}, "from 1 to 5 allowed"},
      {{{"positions", {0, 0}}}, "2 values given, 10 needed"},
      {{{"robot_noise", {0, 0, 0, 0, 0, 0, 2}}}, "value 2 given, a number from -1 to 1 allowed"},
      {{{"target", {1}}, {"cue_steps", {kNan}}}, "cue_steps"},
  };
  const auto batch = make_running(kId);
  for (int i = 0; i < 3; ++i) test::step(*batch, Policy::kRandom);
  const test::Bytes before = test::batch_bytes(*batch);
  const std::vector<std::byte> saved = Snapshotter(*batch).save();
  for (const Case& bad : cases) {
    CHECK_THROWS_WITH(make_env(kId, {.pins = bad.pins}), Catch::Contains(bad.message));
    ResetRequest request;
    request.pins = &bad.pins;
    CHECK_THROWS_WITH(batch->reset(request), Catch::Contains(bad.message));
    CHECK(test::batch_bytes(*batch) == before);
    CHECK(Snapshotter(*batch).save() == saved);  // pins included
  }
}

TEST_CASE("An unknown draw is refused with the names of those there are", "[pins]") {
  CHECK_THROWS_WITH(make_env(kId, {.pins = {{"colour", {1}}}}),
                    Catch::Contains("robot_noise, target, positions, cue_steps, empty_steps"));
}

}  // namespace
}  // namespace engram
