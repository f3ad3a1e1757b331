#include "apps/progress.h"

#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

TEST_CASE("Without a terminal there is no progress bar", "[apps]") {
  const CommandResult result =
      engram_command("rollout RememberColor3-VLA-v0 --num-envs 1 --steps 5 --json");
  CHECK(result.code == 0);
  CHECK(result.err.empty());
  apps::Progress progress("test", "steps");  // of a test, which has no terminal, likewise
  progress.update(2.0, -1);
}

}  // namespace
}  // namespace engram::test
