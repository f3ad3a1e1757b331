// Policies behind servers: options of the command line, and the command of the bridge.
#include "apps/policy_server.h"

#include <catch2/catch.hpp>
#include <fstream>

#include "apps/policy_command.h"
#include "apps/python_module.h"
#include "tests/apps/command.h"
#include "tests/temporary_folder.h"

namespace engram::test {
namespace {

const std::string kEval = "eval RememberColor3-VLA-v0 --episodes 1 ";

// A program that stands for Python.
std::string python(const TemporaryFolder& folder, const std::string& script) {
  const std::filesystem::path path = folder.path() / "python";
  std::ofstream(path) << "#!/bin/sh\n" << script << '\n';
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return "ENGRAM_PYTHON='" + path.string() + "'";
}

}  // namespace

TEST_CASE("A shell command has the words as they are", "[apps]") {
  CHECK(apps::shell_command({"a", "b c", "it's", "$x \"y\" \\"}) ==
        R"(exec 'a' 'b c' 'it'\''s' '$x "y" \')");
}

TEST_CASE("A policy server and its options are in the results", "[apps]") {
  apps::PolicyCommand policy;
  CHECK_FALSE(policy.given());
  policy.server.url = "openpi://host:1";
  policy.server.options = {{"--server-keys", "libero"}, {"--replan", "8"}};
  CHECK(policy.given());
  CHECK(to_line(apps::config_of(policy)) ==
        R"({"server":"openpi://host:1","keys":"libero","replan":"8"})");
}

TEST_CASE("The bridge gets server, options and timeout", "[apps]") {
  const TemporaryFolder folder;
  const CommandResult result = engram_command(
      kEval + "--policy-server gr00t://host:7 --replan 4 --history '3,2' --policy-timeout 9 " +
          "--server-keys 'my keys.json'",
      "", python(folder, "shift 2; printf '%s\\n' \"$@\" >&2; exit 3"));
  CHECK(result.code == 1);
  CHECK(result.err ==
        "bridge\ngr00t://host:7\n--timeout=9\n--replan=4\n--history=3,2\n"
        "--server-keys=my keys.json\n"
        "engram: policy server 'gr00t://host:7' ended with exit code 3\n");
}

TEST_CASE("The bridge gets a command that has chunks cut, and results say so", "[apps]") {
  const TemporaryFolder folder;
  const CommandResult result =
      engram_command(kEval + "--policy-command 'cat >&2' --replan 4 --history since-last", "",
                     python(folder, "shift 2; printf '%s\\n' \"$@\" >&2; exit 3"));
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::StartsWith("bridge\n--command=cat >&2\n--timeout=300\n--replan=4\n"
                                           "--history=since-last\n"));
  apps::PolicyCommand policy;
  policy.command = "cat";
  policy.server.options = {{"--replan", "4"}};
  CHECK(to_line(apps::config_of(policy)) == R"({"command":"cat","replan":"4"})");
}

TEST_CASE("A Python without the package is reported", "[apps]") {
  const TemporaryFolder folder;
  const CommandResult result = engram_command(kEval + "--policy-server act://host --threads 1", "",
                                              python(folder, "exec python3 -I -S \"$@\""));
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::Contains("--policy-server needs the Python package"));
  CHECK_THAT(result.err, Catch::Contains("policy server 'act://host' ended with exit code 1"));
}

TEST_CASE("Options of servers need one, and there is one policy", "[apps]") {
  require_refusal(kEval + "--server-keys libero", 2, "requires --policy-server");
  for (const char* option : {"--replan 3", "--history last"}) {
    require_refusal(kEval + option, 2, "requires --policy-command");
  }
  require_refusal(kEval + "--policy-server ''", 2, "--policy-server: '' given");
  require_refusal(kEval + "--policy-server act://x --policy oracle", 2, "--policy");
  require_refusal(kEval + "--policy-server act://x --policy-command y", 2, "--policy-command");
  require_refusal(kEval + "--policy-server act://x --policy-name oracle", 2, "--policy-name");
}

TEST_CASE("serve: Python gets the arguments of the command line", "[apps]") {
  const TemporaryFolder folder;
  const CommandResult result = engram_command(
      "serve --policy oracle --protocol act --port 0 --chunk 8 --set A=1 --set B=2,3", "",
      python(folder, "shift 2; printf '%s\\n' \"$@\""));
  INFO(result.err);
  CHECK(result.code == 0);
  CHECK(result.out ==
        "serve\n--policy=oracle\n--protocol=act\n--port=0\n--chunk=8\n--set=A=1\n--set=B=2,3\n");
  require_refusal("serve", 2, "--policy is required");
}

}  // namespace engram::test
