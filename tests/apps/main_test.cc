// Exit codes, messages and help of the command.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"
#include "tests/build_paths.h"
#include "tests/sanitizers.h"

namespace engram::test {

TEST_CASE("command: version and help go to standard output", "[apps]") {
  const CommandResult version = engram_command("--version");
  CHECK(version.code == 0);
  CHECK(version.out == "engram 0.6.0\n");
  CHECK(version.err.empty());
  for (const char* command : {"", "list", "info", "rollout", "eval", "bench", "verify", "soak",
                              "record", "play", "check", "serve", "doctor"}) {
    const CommandResult help = engram_command(std::string(command) + " --help");
    CHECK(help.code == 0);
    CHECK_THAT(help.out, Catch::Contains("--help") && Catch::Contains(command));
    CHECK(help.err.empty());
  }
}

TEST_CASE("command: libraries of films are loaded for films alone", "[apps]") {
  const std::string watched = "LD_DEBUG=files";
  const TemporaryFolder folder;
  const std::string film = (folder.path() / "a.gif").string();
  const std::string rollout = "rollout RememberColor3-VLA-v0 --steps 1";
  CHECK_THAT(engram_command(rollout, "", watched).err,
             Catch::Contains("libcairo") && !Catch::Contains("libavcodec"));
  CHECK_THAT(
      engram_command("record RememberColor3-VLA-v0 --size 64 --out " + film, "", watched).err,
      Catch::Contains("libavcodec"));
}

TEST_CASE("command: usage errors are one line and exit code 2", "[apps]") {
  require_refusal("", 2, "no command");
  require_refusal("fly", 2, "fly");
  require_refusal("evl", 2, "did you mean 'eval'?");
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
  require_refusal("rollout InterceptSlow-VLA-v0 --option touch=1", 2, "this task has: none");
  require_refusal(
      "rollout RememberColor9-VLA-v0 --steps 2 --policy oracle --control-mode pd_ee_pose", 2,
      "pd_ee_delta_pose");
  require_refusal("eval", 2, "--all");
  require_refusal("eval RememberColor3-VLA-v0 --all", 2, "one or the other");
  require_refusal("bench nothing", 2, "overhead");
  require_refusal("verify RememberColor3-VLA-v0 --split short", 2, "one or the other");
  require_refusal("verify --obs depth", 2, "state|rgb|objects");
  require_refusal("verify --steps 0", 2, "1 to 10000");
}

TEST_CASE("command: unknown observations and renderers are named with those that exist", "[apps]") {
  require_refusal("rollout RememberColor9-VLA-v0 --obs depth", 2, "state or rgb or objects");
  require_refusal("rollout RememberColor9-VLA-v0 --obs rgb --renderer gpu", 2, "cpu or egl");
}

TEST_CASE("command: failures of the system have exit code 1", "[apps]") {
  require_refusal("info RememberColor9-VLA-v0 --mjcf /nowhere/scene.xml", 1, "/nowhere/scene.xml");
  require_refusal("eval RememberColor3-VLA-v0 --episodes 1 --out /proc/results", 1,
                  "/proc/results");
}

TEST_CASE("command: devices and pipes are written to, not replaced", "[apps]") {
  const TemporaryFolder folder;
  const auto full = folder.path() / "full.xml";
  std::filesystem::create_symlink("/dev/full", full);
  require_refusal("info RememberColor3-VLA-v0 --mjcf " + full.string(), 1, "No space left");
  CHECK(std::filesystem::is_symlink(full));
  CHECK(std::filesystem::is_character_file("/dev/full"));

  const auto pipe = folder.path() / "pipe.xml";
  const auto copy = folder.path() / "copy.xml";
  const std::string line = "mkfifo '" + pipe.string() + "' && { cat '" + pipe.string() + "' >'" +
                           copy.string() + "' & '" + test::kCommand +
                           "' info RememberColor3-VLA-v0 --mjcf '" + pipe.string() +
                           "' >/dev/null; wait; }";
  CHECK(std::system(line.c_str()) == 0);
  CHECK(std::filesystem::is_fifo(pipe));
  CHECK_THAT(read_file(copy), Catch::Contains("<mujoco") && Catch::Contains("</mujoco>"));
}

TEST_CASE("command: a file beyond the allowed size is an error, not the end by a signal",
          "[apps]") {
  const TemporaryFolder folder;
  const std::string scene = (folder.path() / "scene.xml").string();
  const std::string line = std::string("ulimit -f 1; ") + test::kNoTemporaryFolder + "'" +
                           test::kCommand + "' info RememberColor3-VLA-v0 --mjcf '" + scene +
                           "' 2>&1 >/dev/null | " +
                           "grep -q 'engram: .*cannot be written: File too large'";
  CHECK(std::system(line.c_str()) == 0);
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("command: a closed pipe is an error of one line", "[apps]") {
  const TemporaryFolder folder;
  const std::string err = (folder.path() / "err").string();
  for (const char* arguments : {"list", "list --json", "info RememberColor3-VLA-v0 --json",
                                "doctor --json", "rollout RememberColor3-VLA-v0 --steps 2 --json",
                                "bench overhead --rounds 1 --num-envs 1 --json",
                                "eval RememberColor3-VLA-v0 --episodes 1 --json"}) {
    // The command starts once nothing can be written to the pipe any more.
    const std::string line =
        "bash -c \"set -o pipefail; "
        "{ (trap '' PIPE; while printf x; do sleep 0.01; done) 2>/dev/null; '" +
        std::string(test::kCommand) + "' " + arguments + " 2>'" + err + "'; } | true\"";
    const int status = std::system(line.c_str());
    INFO(arguments << ": " << read_file(err));
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 1);
    const std::string text = read_file(err);
    CHECK_THAT(text, Catch::Contains("standard output cannot be written: Broken pipe"));
    CHECK(std::count(text.begin(), text.end(), '\n') == 1);
  }
}

TEST_CASE("command: an output that cannot be written is a failure", "[apps]") {
  for (const char* redirect : {">/dev/full", ">&-"}) {
    const CommandResult result = engram_command("list", redirect);
    INFO(redirect);
    CHECK(result.code == 1);
    CHECK_THAT(result.err, Catch::Contains("standard output"));
  }
}

}  // namespace engram::test
