#include "tasks/common/random_variables.h"

#include <catch2/catch.hpp>

#include "tests/env_helpers.h"

namespace engram {
namespace {

using tasks::RandomVariables, tasks::SampledRange, tasks::StepRange;

// Three random variables, as a family declares them.
struct Variables {
  Variables(RandomVariables list, const StepRange& range)
      : color(list.integer("color", {0, 4}, "", "of the cube")),
        steps(list.of(range, 3)),
        places(list.add({"places", 4, false, -1, 1, "m", "x, y of both cubes"})) {}

  tasks::IntegerVariable color;
  tasks::IntegerVariable steps;
  tasks::VariableHandle places;
};

constexpr StepRange kRange{2, 5, {"cue_steps", "length of the cue"}, "control steps", "CUE_STEPS"};

TEST_CASE("Random variables are described in the order of their declaration", "[parts][draws]") {
  std::vector<RandomVariable> draws;
  const Variables variables(RandomVariables(draws), kRange);
  REQUIRE(draws.size() == 3);
  CHECK(variables.color.index() == 0);
  CHECK(variables.steps.index() == 1);
  CHECK(variables.places.index() == 2);
  CHECK(draws[0].name == "color");
  CHECK(draws[0].integer);
  CHECK(draws[0].high == 4);
  CHECK(draws[1].name == "cue_steps");
  CHECK(draws[1].width == 3);
  CHECK(draws[1].low == 2);
  CHECK(draws[1].constant == "CUE_STEPS");
  CHECK(draws[2].width == 4);
  CHECK_FALSE(draws[2].integer);
}

TEST_CASE("Handles sample the streams of their index, pins and narrower ranges", "[parts][draws]") {
  std::vector<RandomVariable> draws = {
      {.name = "robot_noise", .width = 7, .unit = "", .description = ""}};
  std::vector<RandomVariable> own;
  const Variables variables(RandomVariables(own), kRange);
  draws.insert(draws.end(), own.begin(), own.end());
  ColumnStore store(1);
  const PinTable pins(store, draws);
  const Episode episode(pins, 0, 11, 0);
  CHECK(variables.color.sample(episode) == episode.integer(0, 0, 4));
  CHECK(variables.steps.sample(episode) == episode.integer(1, 2, 5));
  CHECK(variables.places.pinned(episode) == nullptr);
  CHECK(variables.places.stream(episode).uniform() == episode.stream(2).uniform());

  pins.set(0, {{"color", {3}}});
  CHECK(variables.color.sample(episode) == 3);
  pins.narrow(0, pins.narrowed_ranges({{"CUE_STEPS", ConstantList{4, 4}}}));
  CHECK(variables.steps.sample(episode) == 4);
  CHECK(variables.steps.interval(episode).low == 4);
}

}  // namespace
}  // namespace engram
