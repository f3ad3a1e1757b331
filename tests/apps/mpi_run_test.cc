#include "apps/mpi_run.h"

#include <catch2/catch.hpp>
#include <stdexcept>

namespace engram::apps {
namespace {

TEST_CASE("A command outside MPI runs once, as the root", "[apps]") {
  int runs = 0;
  with_mpi(MpiMode::kAuto, [&runs](Ranks& ranks) {
    CHECK(ranks.is_root());
    CHECK(ranks.is_single());
    ++runs;
  });
  CHECK(runs == 1);
}

TEST_CASE("A failure of a single process is thrown on", "[apps]") {
  CHECK_THROWS_WITH(with_mpi(MpiMode::kAuto, [](Ranks&) { throw std::runtime_error("broken"); }),
                    "broken");
}

}  // namespace
}  // namespace engram::apps
