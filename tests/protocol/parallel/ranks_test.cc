#include "protocol/parallel/ranks.h"

#include <catch2/catch.hpp>
#include <cstdlib>

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

TEST_CASE("A launcher of one process is none", "[work]") {
  for (const char* variable : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"}) {
    REQUIRE(::setenv(variable, "1", 1) == 0);
    CHECK(join_ranks()->is_single());
    REQUIRE(::unsetenv(variable) == 0);
  }
}

TEST_CASE("A broadcast in a single process is what the root sends", "[work]") {
  Ranks ranks;
  const Bytes bytes = {std::byte{1}, std::byte{2}};
  CHECK(broadcast(ranks, bytes) == bytes);
}

}  // namespace
}  // namespace engram
