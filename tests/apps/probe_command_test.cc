// `engram probe`.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

TEST_CASE("probe: the same for any threads, as JSON, as files and as a table", "[apps][probe]") {
  const TemporaryFolder folder;
  const std::string out = (folder.path() / "probes").string();
  const std::string words =
      "probe RememberColor3-VLA-v0 --policy blind --probes twins,interference --episodes 3 ";
  const CommandResult one = engram_command(words + "--json --threads 1 --num-envs 1 --out " + out);
  INFO(one.err);
  REQUIRE(one.code == 0);
  CHECK(engram_command(words + "--json --threads 2 --num-envs 8").out == one.out);
  CHECK(read_file(folder.path() / "probes" / "probe.json") == one.out);
  CHECK_THAT(read_file(folder.path() / "probes" / "probe.html"), Catch::Contains("<svg"));
  const ParsedJson document = ParsedJson::parse(one.out);
  CHECK(document["settings"]["obs_mode"] == "objects");
  CHECK(document["tasks"][0]["twins"]["both_follow"]["rate"] == 0.0);
  CHECK(!document["tasks"][0].contains("capacity"));
  CHECK_THAT(engram_command(words).out,
             Catch::Contains("RememberColor3-VLA-v0") && Catch::Contains("presents equal"));
}

TEST_CASE("probe: what cannot be probed is refused", "[apps][probe]") {
  require_refusal("probe", 2, "");
  require_refusal("probe RememberColor3-VLA-v0 --probes twin", 2,
                  "--probes: 'twin' given, twins, forgetting, interference, capacity");
  require_refusal("probe RememberColor3-VLA-v0 --other Remember-v0", 2, "Remember-v0");
  require_refusal("probe RememberColor3-VLA-v0 --policy oracle --policy-command true", 2, "");
}

TEST_CASE("probe: options of eval that it refuses are no part of its help", "[apps][probe]") {
  const CommandResult help = engram_command("probe --help");
  CHECK(help.code == 0);
  CHECK_THAT(help.out, Catch::Contains("--policy-command") && Catch::Contains("--policy-server"));
  for (const char* option : {"--policy-choices", "--choices-stride", "--tell-episodes"}) {
    CHECK_THAT(help.out, !Catch::Contains(option));
    CHECK_THAT(engram_command("eval --help").out, Catch::Contains(option));
  }
  const std::string probe = "probe RememberColor3-VLA-v0 ";
  require_refusal(probe + "--policy-choices true", 2,
                  "--policy-choices: given, --policy-command or --policy-server needed");
  // Not what else would be wrong with choices.
  require_refusal("probe InterceptMedium-VLA-v0 --policy-choices true --choices-stride 2", 2,
                  "--policy-choices: given");
  require_refusal(probe + "--policy-command true --tell-episodes", 2,
                  "--tell-episodes: given, not allowed");
  require_refusal(probe + "--tell-episodes", 2, "--tell-episodes requires --policy-command");
}

TEST_CASE("probe: ranks under mpirun give the same bytes", "[apps][probe]") {
  if (!has_mpi()) {
    WARN("no MPI in this build; nothing checked");
    return;
  }
  const TemporaryFolder folder;
  const std::string words =
      "probe RememberColor3-VLA-v0 ShellGameTouch-VLA-v0 --policy random --episodes 3 "
      "--num-envs 1 --threads 1 --probes twins,interference,capacity --json ";
  const CommandResult alone = engram_command(words);
  REQUIRE(alone.code == 0);
  for (const int count : {1, 2, 3}) {
    const std::string out = (folder.path() / std::to_string(count)).string();
    const CommandResult ranks = command_of_ranks(count, words + "--out " + out);
    INFO(ranks.err);
    CHECK(ranks.code == 0);
    CHECK(ranks.out == alone.out);
    CHECK(read_file(folder.path() / std::to_string(count) / "probe.json") == alone.out);
  }
  // Processes of a policy, one for each thread of a rank.
  const std::string piped =
      "probe ShellGameTouch-VLA-v0 --obs objects --episodes 3 --num-envs 1 --threads 1 "
      "--probes twins --json --policy-command '" +
      pipe_policy() + "'";
  const CommandResult of_process = engram_command(piped);
  REQUIRE(of_process.code == 0);
  CHECK(command_of_ranks(2, piped).out == of_process.out);
  // A mistake ends all of them, and is reported once.
  const CommandResult wrong = command_of_ranks(3, words + "--policy-command true --tell-episodes");
  CHECK(wrong.code != 0);
  CHECK(wrong.code != 124);
  const CommandResult unknown = command_of_ranks(3, words + "--other NoSuchTask-VLA-v0");
  CHECK(unknown.code != 0);
  CHECK(unknown.code != 124);
  const std::size_t first = unknown.err.find("no task 'NoSuchTask");
  CHECK(first != std::string::npos);
  CHECK(unknown.err.find("no task", first + 1) == std::string::npos);
}

}  // namespace
}  // namespace engram::test
