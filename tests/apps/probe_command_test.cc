// `engram probe`.
#include <catch2/catch.hpp>
#include <string>

#include "tests/apps/command.h"

namespace engram::tests {
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
  const Json document = Json::parse(one.out);
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

}  // namespace
}  // namespace engram::tests
