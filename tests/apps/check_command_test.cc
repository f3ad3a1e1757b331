// `engram check`: arguments passed to Python, and errors without Python.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"
#include "tests/apps/fake_python.h"
#include "tests/temporary_folder.h"

namespace engram::test {
TEST_CASE("check: Python gets the arguments of the command line", "[apps]") {
  const TemporaryFolder folder;
  const CommandResult result = engram_command(
      "check tasks.py 'two words.py:A-v0' --fast --json --episodes 50 --only runs --only leaks "
      "--hidden target",
      "", fake_python(folder, kPrintArguments));
  INFO(result.err);
  CHECK(result.code == 0);
  CHECK(result.out ==
        "--episodes=50\n--fast\n--json\n--hidden=target\n--only=runs\n--only=leaks\n--\n"
        "tasks.py\ntwo words.py:A-v0\n");
}

TEST_CASE("check: a missing Python is reported in one line", "[apps]") {
  const CommandResult result =
      engram_command("check tasks.py", "", "ENGRAM_PYTHON=/nowhere/python");
  CHECK(result.code == 1);
  CHECK(result.err ==
        "engram: check needs Python: '/nowhere/python' cannot be started: "
        "No such file or directory\n");
}

TEST_CASE("check: tasks are needed, and unknown options refused", "[apps]") {
  require_refusal("check", 2, "tasks");
  require_refusal("check tasks.py --token x", 2, "--token");
}

}  // namespace engram::test
