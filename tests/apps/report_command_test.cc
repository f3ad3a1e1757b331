// `engram report`.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

TEST_CASE("report: tables of a run's folder", "[apps]") {
  const TemporaryFolder folder;
  REQUIRE(engram_command("eval RememberColor3-VLA-v0 TakeItBack-VLA-v0 --episodes 3 --out " +
                         folder.path().string())
              .code == 0);
  const std::filesystem::path run =
      std::filesystem::directory_iterator(folder.path() / "short")->path();
  const auto report = [&run](const std::string& options) {
    const CommandResult result = engram_command("report " + run.string() + " " + options);
    INFO(result.err);
    REQUIRE(result.code == 0);
    return result.out;
  };
  CHECK_THAT(report(""), Catch::StartsWith("| task | split | success |"));
  CHECK_THAT(report("--format latex"), Catch::StartsWith("\\begin{tabular}"));
  CHECK(report("--format csv") == read_file(run / "summary.csv"));
  CHECK(report("--format episodes") == read_file(run / "episodes.csv"));
  const ParsedJson entry = ParsedJson::parse(report("--format vla-eval"));
  CHECK(entry["benchmark"] == "mikasa");
  CHECK(entry["overall_score"].is_null());
  const std::string out = (folder.path() / "table.md").string();
  CHECK(report("--out " + out).empty());
  CHECK(read_file(out) == report("--format md"));
}

TEST_CASE("report: what is no result is refused", "[apps]") {
  const TemporaryFolder folder;
  require_refusal("report " + folder.path().string(), 2, "a folder without results");
  require_refusal("report " + folder.path().string() + " --format word", 2,
                  "--format: 'word' given, md, latex, csv, episodes, vla-eval allowed");
  require_refusal("report " + (folder.path() / "none").string(), 1, "does not exist");
}

}  // namespace
}  // namespace engram::test
