#include "apps/policy_command.h"

#include <catch2/catch.hpp>

namespace engram::apps {
namespace {

TEST_CASE("Results name engram's own policies, or the command", "[apps]") {
  EvaluationSettings settings;
  name_policy({}, Policy::kOracle, settings);
  CHECK(settings.policy == "oracle");
  CHECK(is_null(settings.policy_config));
  CHECK(is_null(config_of({})));

  const PolicyCommand command{.command = "python3 policy.py", .name = ""};
  CHECK(command.given());
  name_policy(command, Policy::kOracle, settings);
  CHECK(settings.policy == "external");
  CHECK(text(part(settings.policy_config, "command")) == "python3 policy.py");
  name_policy({.command = "x", .name = "mine"}, Policy::kOracle, settings);
  CHECK(settings.policy == "mine");
}

TEST_CASE("An external policy cannot have the name of one of engram's own", "[apps]") {
  EvaluationSettings settings;
  for (const char* name : {"oracle", "sweep", "blind", "random", "zero", "Oracle"}) {
    CHECK_THROWS_WITH(name_policy({.command = "x", .name = name}, Policy::kZero, settings),
                      Catch::StartsWith(std::string("--policy-name: '") + name + "' given"));
  }
  CHECK_NOTHROW(name_policy({.command = "x", .name = "oracle2"}, Policy::kZero, settings));
}

TEST_CASE("A policy's process gets command, timeout and observations", "[apps]") {
  MakeOptions environment;
  environment.obs_mode = ObsMode::kRgb;
  const PolicyProcessOptions options =
      process_options({.command = "x", .name = "", .timeout = 7}, environment, 5);
  CHECK(options.command == "x");
  CHECK(options.timeout == std::chrono::seconds(7));
  CHECK(options.max_slots == 5);
  CHECK(options.environment.obs_mode == ObsMode::kRgb);
}

}  // namespace
}  // namespace engram::apps
