// Options of tasks: defaults, choices and refusals.
#include "core/task/task_option.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/base/error.h"
#include "core/batch/options.h"
#include "tests/core/batch/scene_task.h"

namespace engram {
namespace {

const std::vector<TaskOptionSpec> kOptions = {
    {"touch_radius", 0.05, false, 0.001, 0.2, "m", "how near counts"},
    {"strict", 0, true, 0, 1, "", "a switch"},
};
const std::vector<TaskOptionSpec> kDeparting = {
    {"touch_radius", 0.05, false, 0.001, 0.2, "m", "how near counts", 0.02},
    {"gain", 3, true, 0, 9, "", "the same in both"},
};

TEST_CASE("Options have their defaults until the user chooses", "[options]") {
  CHECK(option_values(kOptions, {}) == std::vector<double>{0.05, 0});
  const std::vector<TaskOptionValue> choices = {{"strict", 1}, {"touch_radius", 0.02}};
  CHECK(option_values(kOptions, choices) == std::vector<double>{0.02, 1});
  CHECK(option_values({}, {}).empty());
}

TEST_CASE("Options that nobody chooses follow the rules", "[options][rules]") {
  using Values = std::vector<double>;
  CHECK(option_values(kDeparting, {}, Rules::kReference) == Values{0.05, 3});
  CHECK(option_values(kDeparting, {}, Rules::kOriginal) == Values{0.02, 3});
  const std::vector<TaskOptionValue> choices = {{"touch_radius", 0.05}};
  CHECK(option_values(kDeparting, choices, Rules::kOriginal) == Values{0.05, 3});
}

TEST_CASE("Choices that are not allowed are refused", "[options]") {
  struct Case {
    std::vector<TaskOptionValue> choices;
    const char* message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const Case cases[] = {
      {{{"radius", 1}}, "no option named 'radius'; this task has: touch_radius, strict"},
      {{{"strict", 0.5}}, "0.5 given"},
      {{{"strict", 2}}, "option 'strict': 2 given, a whole number from 0 to 1 allowed"},
      {{{"touch_radius", 0}}, "0 given, a number from 0.001 to 0.2 allowed"},
      {{{"touch_radius", nan}}, "nan given"},
      {{{"strict", 1}, {"strict", 1}}, "given twice"},
  };
  for (const Case& bad : cases) {
    CHECK_THROWS_WITH(option_values(kOptions, bad.choices), Catch::Contains(bad.message));
  }
  CHECK_THROWS_WITH(option_values({}, cases[0].choices), Catch::Contains("this task has: none"));
}

TEST_CASE("A task is given its options when it is bound", "[options]") {
  const auto given = [](const std::vector<TaskOptionValue>& choices) {
    auto task = std::make_unique<test::SceneTask>();
    task->description.options = kOptions;
    const test::SceneTask& seen = *task;
    const BatchOptions options{.task_options = choices};
    const Batch batch(std::move(task), options);
    return std::vector<double>(seen.engine.options.begin(), seen.engine.options.end());
  };
  CHECK(given({}) == std::vector<double>{0.05, 0});
  CHECK(given({{"strict", 1}}) == std::vector<double>{0.05, 1});
  CHECK_THROWS_WITH(given({{"strict", 7}}), Catch::Contains("7 given"));
}

}  // namespace
}  // namespace engram
