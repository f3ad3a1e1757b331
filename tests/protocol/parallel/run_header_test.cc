#include "protocol/parallel/run_header.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("Run header: read as it was written", "[shares]") {
  const RunHeader header{.kind = "eval",
                         .shard = Shard{3, 7},
                         .command = {"engram", "eval", "it's", "--shard", "3/7"},
                         .run = JsonTable{{"seed", 1}},
                         .tasks = {{"a", {50, 90}}, {"b", {1, 60}}}};
  const RunHeader read = RunHeader::of(header.document(), "file");
  CHECK(Json(read.document()) == Json(header.document()));
  CHECK(read.shard == Shard{3, 7});
  CHECK(read.loads().at(1).horizon == 60);
  CHECK_THROWS_WITH(RunHeader::of(JsonTable{{"kind", 3}}, "file"), Catch::Contains("'file'"));
}

TEST_CASE("Run header: the command of another shard", "[shares]") {
  RunHeader header;
  header.command = {"engram", "eval", "it's", "--shard", "3/7", "--out", "a b"};
  CHECK(header.command_of({5, 7}) == "engram eval 'it'\\''s' --shard 5/7 --out 'a b'");
  CHECK(header.command_of_whole("c") == "engram eval 'it'\\''s' --out c");
  header.command = {"engram", "eval", "--shard=3/7", ""};
  CHECK(header.command_of_whole("c") == "engram eval '' --out c");
  CHECK(header.command_of({5, 7}) == "engram eval --shard=5/7 ''");
}

}  // namespace
}  // namespace engram
