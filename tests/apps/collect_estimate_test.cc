// `engram collect --estimate`.
#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "tests/apps/command.h"

namespace engram::test {

namespace fs = std::filesystem;

TEST_CASE("collect: an estimate comes near what is made, and makes nothing", "[apps]") {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const std::string command =
      "collect RememberColor3-VLA-v0 BlinkCountButtonPressEasy-VLA-v0 --episodes 20 --out " +
      out.string();
  const ParsedJson estimate = engram_command(command + " --json --estimate").json();
  CHECK_FALSE(fs::exists(out));
  const ParsedJson made = engram_command(command + " --json").json();
  for (std::size_t i = 0; i < 2; ++i) {
    const ParsedJson& task = estimate["tasks"][i];
    double bytes = 0;
    for (const auto& file : fs::directory_iterator(made["tasks"][i]["out"].get<std::string>())) {
      if (file.path().extension() == ".npz") bytes += static_cast<double>(file.file_size());
    }
    INFO(task);
    CHECK(task["env_id"] == made["tasks"][i]["env_id"]);
    CHECK(task["episodes"] == 20);
    CHECK(task["bytes"].get<double>() == Approx(bytes).epsilon(0.3));
    CHECK(task["steps"].get<double>() ==
          Approx(made["tasks"][i]["steps"].get<double>()).epsilon(0.3));
    CHECK(task["thread_seconds"].get<double>() > 0);
  }
  CHECK_THAT(engram_command(command + " --estimate").out, Catch::Contains("nothing was written"));
}

}  // namespace engram::test
