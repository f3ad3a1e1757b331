// `engram verify` as scripts use it.
#include <catch2/catch.hpp>

#include "tests/apps/command.h"
#include "tests/build_paths.h"
#include "tests/sanitizers.h"

namespace engram::test {

TEST_CASE("command: verify reports the comparisons", "[apps]") {
  const std::string arguments = "verify ShellGameTouch-VLA-v0 RememberColor3-VLA-v0 --steps 1";
  const ParsedJson rows = engram_command(arguments + " --json").json();
  REQUIRE(rows.size() == 6);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const ParsedJson& row = rows[i];
    CHECK(keys_of(row) == std::vector<std::string>{"id", "obs", "plays", "episodes", "env_steps",
                                                   "different", "fingerprint"});
    CHECK(row["id"] == (i % 2 == 0 ? "ShellGameTouch-VLA-v0" : "RememberColor3-VLA-v0"));
    CHECK(row["obs"] == (i < 2 ? "state" : i < 4 ? "rgb" : "objects"));
    CHECK(row["env_steps"] > 18 * 128);
    CHECK(row["different"] == 0);
    CHECK(row["fingerprint"].get<std::string>().size() == 16);
    for (std::size_t other = 0; other < i; ++other) {
      CHECK(row["fingerprint"] != rows[other]["fingerprint"]);
    }
  }
  const CommandResult words = engram_command(arguments + " --obs state");
  CHECK(words.code == 0);
  CHECK_THAT(words.out, Catch::Contains("fingerprint") &&
                            Catch::Contains(rows[0]["fingerprint"].get<std::string>()) &&
                            !Catch::Contains("rgb"));
}

TEST_CASE("command: verify fails if results depend on the order of work", "[apps]") {
  if (test::kSanitized) return;  // sanitizers want to be the first that is loaded
  const std::string environment =
      std::string("LD_PRELOAD='") + test::kNondeterministicContacts + "'";
  const std::string arguments = "verify InterceptSlow-VLA-v0 --obs state --steps 2 --json";
  const CommandResult result = engram_command(arguments, "", environment);
  CHECK(result.code == 1);
  CHECK_THAT(result.err, Catch::Contains("1 of 1 checks found different bits"));
  CHECK(ParsedJson::parse(result.out)[0]["different"] > 0);
}

}  // namespace engram::test
