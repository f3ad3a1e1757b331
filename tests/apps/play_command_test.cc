// `engram play`: arguments passed to Python, and errors without Python.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"
#include "tests/apps/fake_python.h"
#include "tests/build_paths.h"
#include "tests/temporary_folder.h"

namespace engram::test {
TEST_CASE("play: Python gets the arguments of the command line", "[apps]") {
  const TemporaryFolder folder;
  const std::string variants = std::string(test::kRoot) + "/apps/examples/medium_variants.json";
  const CommandResult result =
      engram_command("--variants '" + variants +
                         "' play --no-open --port 8080 --folder one --folder 'two words' " +
                         "--policy-command 'a; b \"c\"' --physics mujoco --choices --stay",
                     "", fake_python(folder, kPrintArguments));
  INFO(result.err);
  CHECK(result.code == 0);
  CHECK(result.out == "--variants=" + variants +
                          "\n--port=8080\n--no-open\n--folder=one\n--folder=two words\n"
                          "--policy-command=a; b \"c\"\n--physics=mujoco\n--choices\n--stay\n");
}

TEST_CASE("play: a missing Python or package is reported in one line", "[apps]") {
  CommandResult result = engram_command("play", "", "ENGRAM_PYTHON=/nowhere/python");
  CHECK(result.code == 1);
  CHECK(result.err ==
        "engram: play needs Python: '/nowhere/python' cannot be started: "
        "No such file or directory\n");
  const TemporaryFolder folder;
  // -I, -S: nothing but the standard library.
  result = engram_command("play", "", fake_python(folder, "exec python3 -I -S \"$@\""));
  CHECK(result.code == 1);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Catch::Contains("needs the Python package of this project"));
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
}

TEST_CASE("play: options that are empty or unknown are refused", "[apps]") {
  require_refusal("play --policy-command ''", 2, "--policy-command");
  require_refusal("play --token x", 2, "--token");
}

}  // namespace engram::test
