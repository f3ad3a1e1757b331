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
  BatchOptions options;
  options.num_envs = 3;
  BatchGroup batch(test::make_env(kId, options));
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
    REQUIRE(test::batch_bytes(batch.part(0)) == test::batch_bytes(*twin));
  }
}

TEST_CASE("Actions that a step refuses start nothing", "[step_driver]") {
  BatchGroup batch(test::make_env(kId));
  StepDriver driver(batch);
  std::vector<float> actions = test::zeros(batch.part(0));
  CHECK_THROWS_WITH(driver.start(actions), Catch::Contains("before the first reset"));
  batch.reset();
  actions[2] = std::numeric_limits<float>::infinity();
  CHECK_THROWS_WITH(driver.start(actions), Catch::Contains("component 2"));
  driver.wait();
  CHECK(batch.part(0).state().elapsed[0] == 0);
}

TEST_CASE("A driver waits for its step before it ends", "[step_driver]") {
  BatchOptions options;
  options.num_envs = 8;
  BatchGroup batch(test::make_env(kId, options));
  batch.reset();
  { StepDriver(batch).start(test::zeros(batch.part(0))); }
  for (int i = 0; i < 8; ++i) CHECK(batch.part(0).state().elapsed[i] == 1);
}

}  // namespace
}  // namespace engram::c
