// `engram soak`: its fields, its refusals and its end.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/apps/command.h"
#include "tests/sanitizers.h"

namespace engram::test {
namespace {

constexpr const char* kId = "RememberColor3-VLA-v0";

TEST_CASE("soak: an interrupted command reports its work, and fails", "[apps][soak]") {
  const CommandResult result =
      engram_command(std::string("soak ") + kId + " --env-steps 100000000 --max-drift 1000 --json",
                     // Once it handles the signal; it takes its first sample in any case.
                     "& p=$!; while [ -d /proc/$p ] && "
                     "! grep -q '^SigCgt:.*[4-7c-f]...$' /proc/$p/status; do sleep 0.02; done; "
                     "kill -TERM $p; wait $p");
  INFO(result.err);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::Contains("interrupted; reported is what was done until then"));
  const ParsedJson report = ParsedJson::parse(result.out);
  CHECK(report["stopped"] == true);
  CHECK(report["env_steps"].get<int>() > 0);
}

TEST_CASE("soak: the command's fields, and nothing lost in a few steps and cycles",
          "[apps][soak]") {
  if (test::kSanitized) return;  // the bounds are of the ordinary heap
  const ParsedJson report = engram_command(std::string("soak ") + kId +
                                           " TakeItBack-VLA-v0 --env-steps 600 --cycles 40 "
                                           "--max-drift 1000 --json")
                                .json();
  CHECK(keys_of(report) == std::vector<std::string>{"env_steps", "cycles", "threads", "stopped",
                                                    "step_seconds", "cycle_seconds", "passed",
                                                    "bounds", "unstable", "tasks", "step_samples",
                                                    "cycle_samples"});
  CHECK(report["passed"] == true);
  CHECK(report["env_steps"].get<int>() >= 600);
  CHECK(report["cycles"] == 40);
  CHECK(report["unstable"].empty());
  CHECK(report["tasks"].size() == 2);
  CHECK(report["tasks"][1]["id"] == "TakeItBack-VLA-v0");
  CHECK(report["tasks"][0]["visits"].size() == 3);
  CHECK(report["step_samples"].size() == 6);
  CHECK(report["cycle_samples"].size() == 40);
  for (const ParsedJson& sample : report["cycle_samples"]) {
    CHECK(sample["resident_bytes"].get<double>() > sample["allocated_bytes"].get<double>());
    CHECK(sample["threads"] == 1);
  }
  REQUIRE(report["bounds"].size() == 12);
  for (const ParsedJson& bound : report["bounds"]) {
    INFO(bound["name"]);
    CHECK(bound["kept"] == true);
  }
}

TEST_CASE("soak: refusals", "[apps][soak]") {
  require_refusal("soak RemembrColor3-VLA-v0", 2, kId);
  require_refusal("soak --env-steps -1", 2, "--env-steps");
  require_refusal("soak --max-drift 0", 2, "--max-drift");
  require_refusal("soak --cycles many", 2, "--cycles");
}

}  // namespace
}  // namespace engram::test
