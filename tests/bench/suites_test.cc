#include "bench/suites.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "core/base/error.h"

namespace engram::bench {
namespace {

TEST_CASE("An unknown suite or too few rounds are refused", "[bench]") {
  CHECK_THROWS_WITH(run_suite("nothing", {}), Catch::Contains("overhead"));
  SuiteOptions options;
  options.rounds = 0;
  CHECK_THROWS_WITH(run_suite("overhead", options), Catch::Contains("1 or more"));
}

TEST_CASE("A suite measures with the names of its rows", "[bench]") {
  const auto names = suite_names();
  CHECK(std::find(names.begin(), names.end(), "reset") != names.end());
  SuiteOptions options;
  options.rounds = 1;
  options.num_envs = 2;
  const auto rows = run_suite("reset", options);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].name == "reset");
  CHECK(rows[0].value > 0);
  CHECK(rows[0].ratio > 0);
}

TEST_CASE("MuJoCo's physics is measured beside mj_step alone", "[bench][mujoco_physics]") {
  SuiteOptions options;
  options.ids = {"ShellGamePush-VLA-v0"};
  options.rounds = 1;
  options.num_envs = 2;
  options.physics = Physics::kMujoco;
  options.policy = Policy::kOracle;
  const auto rows = run_suite("physics", options);
  REQUIRE(rows.size() == 1);
  CHECK(rows[0].name == "physics.ShellGamePush-VLA-v0.vs_mj_step");
  CHECK(rows[0].ratio > 0);
}

}  // namespace
}  // namespace engram::bench
