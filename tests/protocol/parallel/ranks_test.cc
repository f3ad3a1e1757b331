#include "protocol/parallel/ranks.h"

#include <catch2/catch.hpp>
#include <cstdlib>
#include <utility>

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

// Left by a launcher to a shell or a Python, whose children have no ranks.
TEST_CASE("Variables that a launcher has left to a program's child start no ranks", "[work]") {
  const std::pair<const char*, const char*> variables[] = {
      {"OMPI_COMM_WORLD_SIZE", "OMPI_COMM_WORLD_SIZE=4"},
      {"PMI_SIZE", "PMI_SIZE=4"},
      {"SLURM_NTASKS", "PMIX_RANK, SLURM_NTASKS=4"}};
  REQUIRE(::setenv("PMIX_RANK", "0", 1) == 0);
  for (const auto& [variable, named] : variables) {
    REQUIRE(::setenv(variable, "4", 1) == 0);
    CHECK_THROWS_WITH(join_ranks(), Catch::Contains(named) && Catch::Contains("is no launcher"));
    CHECK(join_ranks(MpiMode::kOff)->is_single());
    REQUIRE(::unsetenv(variable) == 0);
  }
  REQUIRE(::unsetenv("PMIX_RANK") == 0);
}

TEST_CASE("A broadcast in a single process is what the root sends", "[work]") {
  Ranks ranks;
  const Bytes bytes = {std::byte{1}, std::byte{2}};
  CHECK(broadcast(ranks, bytes) == bytes);
}

}  // namespace
}  // namespace engram
