// `engram collect --stream`: the data files of a folder, without the folder.
#include <catch2/catch.hpp>
#include <cstring>
#include <string>
#include <vector>

#include "tests/apps/command.h"

namespace engram::test {
namespace {

// The blocks of a stream; each has its length before it.
std::vector<std::string> blocks_of(const std::string& stream) {
  std::vector<std::string> blocks;
  std::size_t at = 0;
  while (at < stream.size()) {
    std::uint64_t size = 0;
    REQUIRE(stream.size() - at >= sizeof size);
    std::memcpy(&size, stream.data() + at, sizeof size);
    at += sizeof size;
    REQUIRE(stream.size() - at >= size);
    blocks.push_back(stream.substr(at, size));
    at += size;
  }
  return blocks;
}

}  // namespace

TEST_CASE("collect: a stream has the episodes of the folder and its metadata", "[apps]") {
  const std::string command = "collect ShellGameTouch-VLA-v0 --episodes 3 ";
  const TemporaryFolder folder;
  REQUIRE(engram_command(command + "--out " + folder.path().string()).code == 0);
  const auto path = folder.path() / "data_npz" / "ShellGameTouch-VLA-v0";
  const CommandResult streamed = engram_command(command + "--stream --threads 2");
  REQUIRE(streamed.code == 0);
  const std::vector<std::string> blocks = blocks_of(streamed.out);
  REQUIRE(blocks.size() == 5);
  for (std::size_t i = 0; i < 3; ++i) {
    // Stored instead of deflated.
    const auto file = path / ("train_data_" + std::to_string(i) + ".npz");
    CHECK(blocks[i].starts_with("PK"));
    CHECK(blocks[i].size() > std::filesystem::file_size(file));
  }
  CHECK(blocks[3].empty());
  CHECK(blocks[4] == read_file(path / "metadata.json"));
}

TEST_CASE("collect: a stream is of one task", "[apps]") {
  for (const char* wrong :
       {"ShellGameTouch-VLA-v0 ShellGamePush-VLA-v0", "ShellGameTouch-VLA-v0 --json"}) {
    const CommandResult result =
        engram_command(std::string("collect --stream --episodes 1 ") + wrong);
    CHECK(result.code == 2);
    CHECK_THAT(result.err, Catch::Contains("one task and one process needed"));
    CHECK(result.out.empty());
  }
}

}  // namespace engram::test
