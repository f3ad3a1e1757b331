#include "api/step_driver.h"

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

#include "core/base/error.h"
#include "tests/env_helpers.h"

namespace engram::c {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

TEST_CASE("Steps in another thread have the bits of steps in this one", "[step_driver]") {
  const BatchOptions options{.num_envs = 3};
  const auto made = test::make_env(kId, options);
  Batch& batch = *made;
  const auto twin = test::make_env(kId, options);
  batch.reset();
  twin->reset();
  StepDriver driver(batch);
  for (int i = 0; i < 20; ++i) {
    std::vector<float> actions = test::act(*twin, Policy::kRandom);
    driver.start(actions);
    twin->step(actions);
    std::fill(actions.begin(), actions.end(), std::numeric_limits<float>::quiet_NaN());  // copied
    driver.wait();
    REQUIRE(test::batch_bytes(batch) == test::batch_bytes(*twin));
  }
}

TEST_CASE("Actions that a step refuses start nothing", "[step_driver]") {
  const auto made = test::make_env(kId);
  Batch& batch = *made;
  StepDriver driver(batch);
  std::vector<float> actions = test::zeros(batch);
  CHECK_THROWS_WITH(driver.start(actions), Catch::Contains("before the first reset"));
  batch.reset();
  actions[2] = std::numeric_limits<float>::infinity();
  CHECK_THROWS_WITH(driver.start(actions), Catch::Contains("component 2"));
  driver.wait();
  CHECK(batch.state().elapsed[0] == 0);
}

TEST_CASE("A driver waits for its step before it ends", "[step_driver]") {
  const auto made = test::make_env(kId, {.num_envs = 8});
  Batch& batch = *made;
  batch.reset();
  { StepDriver(batch).start(test::zeros(batch)); }
  for (int i = 0; i < 8; ++i) CHECK(batch.state().elapsed[i] == 1);
}

}  // namespace
}  // namespace engram::c
