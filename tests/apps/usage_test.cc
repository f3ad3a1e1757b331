// Exit codes, messages and help of the command.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"

namespace engram::tests {

TEST_CASE("command: version and help go to standard output", "[apps]") {
  const CommandResult version = engram_command("--version");
  CHECK(version.code == 0);
  CHECK(version.out == "engram 0.1.0\n");
  CHECK(version.err.empty());
  for (const char* command :
       {"", "list", "info", "rollout", "eval", "bench", "soak", "record", "doctor"}) {
    const CommandResult help = engram_command(std::string(command) + " --help");
    CHECK(help.code == 0);
    CHECK_THAT(help.out, Catch::Contains("--help") && Catch::Contains(command));
    CHECK(help.err.empty());
  }
}

TEST_CASE("command: usage errors are one line and exit code 2", "[apps]") {
  require_refusal("", 2, "no command");
  require_refusal("fly", 2, "fly");
  require_refusal("list --nonsense", 2, "--nonsense");
  require_refusal("list --split brief", 2, "short|medium|long|extended");
  require_refusal("list --family Remember", 2, "RememberColor");
  require_refusal("info", 2, "id");
  require_refusal("info RemembrColor9-VLA-v0", 2, "RememberColor9-VLA-v0");
  require_refusal("rollout RememberColor9-VLA-v0 --steps", 2, "--steps");
  require_refusal("rollout RememberColor9-VLA-v0 --steps 0", 2, "1 to");
  require_refusal("rollout RememberColor9-VLA-v0 --steps 5x", 2, "5x");
  require_refusal("rollout RememberColor9-VLA-v0 --num-envs 1000001", 2, "1000000");
  require_refusal("rollout RememberColor9-VLA-v0 --seed -1", 2, "18446744073709551615");
  require_refusal("rollout RememberColor9-VLA-v0 --policy clever", 2, "zero|random|oracle|blind");
  require_refusal("rollout RememberColor9-VLA-v0 --control-mode pd", 2, "pd_ee_delta_pose");
  require_refusal("rollout RememberColor9-VLA-v0 --rotation-sign 0", 2, "-1");
  require_refusal("rollout RememberColor9-VLA-v0 --pin target", 2, "NAME=NUMBER");
  require_refusal("rollout RememberColor9-VLA-v0 --pin target=", 2, "NAME=NUMBER");
  require_refusal("rollout RememberColor9-VLA-v0 --pin colour=1", 2, "target");
  require_refusal("rollout RememberColor9-VLA-v0 --pin target=9", 2, "8");
  require_refusal("rollout RememberColor9-VLA-v0 --option touch", 2, "NAME=NUMBER");
  require_refusal("rollout RememberColor9-VLA-v0 --option touch=1", 2, "this task has: none");
  require_refusal(
      "rollout RememberColor9-VLA-v0 --steps 2 --policy oracle --control-mode pd_joint_pos", 2,
      "pd_ee_delta_pose");
  require_refusal("eval", 2, "--all");
  require_refusal("eval RememberColor3-VLA-v0 --all", 2, "one or the other");
  require_refusal("bench nothing", 2, "overhead");
}

TEST_CASE("command: unknown observations and renderers are named with those that exist", "[apps]") {
  require_refusal("rollout RememberColor9-VLA-v0 --obs depth", 2, "state or rgb");
  require_refusal("rollout RememberColor9-VLA-v0 --obs rgb --renderer gpu", 2, "cpu or egl");
}

TEST_CASE("command: what cannot be done here is a failure, exit code 1", "[apps]") {
  require_refusal("info RememberColor9-VLA-v0 --mjcf /nowhere/scene.xml", 1, "/nowhere/scene.xml");
  require_refusal("eval RememberColor3-VLA-v0 --episodes 1 --out /proc/results", 1,
                  "/proc/results");
}

TEST_CASE("command: an output that cannot be written is a failure", "[apps]") {
  for (const char* redirect : {">/dev/full", ">&-"}) {
    const CommandResult result = engram_command("list", redirect);
    INFO(redirect);
    CHECK(result.code == 1);
    CHECK_THAT(result.err, Catch::Contains("standard output"));
  }
}

}  // namespace engram::tests
