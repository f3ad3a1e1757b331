#include "protocol/parallel/shard_set.h"

#include <catch2/catch.hpp>
#include <filesystem>
#include <set>
#include <string>

#include "protocol/io/files.h"
#include "tests/temporary_folder.h"

namespace engram {
namespace {

namespace fs = std::filesystem;

RunHeader header_of(const Shard& shard, int seed = 1) {
  return {.kind = "eval",
          .shard = shard,
          .command = {"engram", "eval", "a", "--shard", to_text(shard)},
          .run = JsonTable{{"start_seed", seed}},
          .tasks = {{"a", {5, 90}}}};
}

// A folder with the shards of a run; all episodes of each but those left out.
struct Shards {
  test::TemporaryFolder folder;

  fs::path add(const Shard& shard, const std::set<int>& without = {}, int seed = 1) const {
    const fs::path path = folder.path() / shard_folder(shard);
    require_writable_folder(path);
    const OpenFolder opened(path);
    const RunHeader header = header_of(shard, seed);
    Journal journal(opened, header.document());
    const EpisodeRange share = share_of(header.loads(), shard).front();
    for (int i = share.first; i < share.end; ++i) {
      if (!without.contains(i)) journal.add("a", i, {});
    }
    return path;
  }
  ShardSet read() const { return ShardSet(std::vector<fs::path>{folder.path()}); }
};

TEST_CASE("Shard set: all shards of a folder", "[shares]") {
  const Shards shards;
  for (const int number : {2, 3, 1}) shards.add({number, 3});
  const ShardSet set = shards.read();
  CHECK(set.parts().size() == 3);
  CHECK(set.missing().empty());
}

TEST_CASE("Shard set: what is missing, and the command for it", "[shares]") {
  const Shards shards;
  shards.add({1, 3});
  shards.add({2, 3}, {2});
  const auto missing = shards.read().missing();
  REQUIRE(missing.size() == 2);
  CHECK(missing[0].shard == Shard{2, 3});
  CHECK(missing[0].episodes == 1);
  CHECK(missing[0].command == "engram eval a --shard 2/3");
  CHECK(missing[1].shard == Shard{3, 3});
  CHECK(missing[1].episodes == 1);
  CHECK(missing[1].command == "engram eval a --shard 3/3");
}

TEST_CASE("Shard set: what does not belong together is refused", "[shares]") {
  const Shards shards;
  const fs::path first = shards.add({1, 3});
  CHECK_THROWS_WITH(ShardSet(std::vector<fs::path>{first, first}), Catch::Contains("given twice"));
  shards.add({2, 3}, {}, 2);
  CHECK_THROWS_WITH(shards.read(),
                    Catch::Contains("start_seed 1") && Catch::Contains("2; one run"));
  const Shards others;
  const fs::path fourth = others.add({4, 4});
  CHECK_THROWS_WITH(ShardSet(std::vector<fs::path>{first, fourth}),
                    Catch::Contains("shard \"1/3\"") && Catch::Contains("\"4/4\""));
  const test::TemporaryFolder empty;
  CHECK_THROWS_WITH(ShardSet(std::vector<fs::path>{empty.path()}),
                    Catch::Contains("a folder of a shard"));
}

}  // namespace
}  // namespace engram
