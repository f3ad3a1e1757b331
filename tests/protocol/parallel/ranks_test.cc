#include "protocol/parallel/ranks.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("A single process is the root of one rank", "[work]") {
  const std::unique_ptr<Ranks> ranks = join_ranks();
  CHECK(ranks->is_single());
  CHECK(ranks->is_root());
  CHECK(ranks->rank() == 0);
  CHECK(ranks->local_size() == 1);
  CHECK_FALSE(ranks->receive());
}

TEST_CASE("A broadcast in a single process is what the root sends", "[work]") {
  Ranks ranks;
  const Bytes bytes = {std::byte{1}, std::byte{2}};
  CHECK(broadcast(ranks, bytes) == bytes);
}

}  // namespace
}  // namespace engram
