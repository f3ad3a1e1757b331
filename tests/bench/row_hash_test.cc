#include "bench/row_hash.h"

#include <array>
#include <catch2/catch.hpp>
#include <vector>

namespace engram::bench {
namespace {

TEST_CASE("A row's hash depends on its values and on the hash before", "[bench]") {
  const std::vector<float> rows = {1, 2, 3, 4, 1, 2};
  const std::span<const float> all(rows);
  CHECK(chain_row(7, all, 3, 0) == chain_row(7, all, 3, 2));
  CHECK(chain_row(7, all, 3, 0) != chain_row(7, all, 3, 1));
  CHECK(chain_row(7, all, 3, 0) != chain_row(8, all, 3, 0));
  CHECK(chain_row(7, std::span<const float>(), 3, 0) == 7);
}

TEST_CASE("The hash of hashes depends on their order", "[bench]") {
  CHECK(hash_of(std::array<std::uint64_t, 2>{1, 2}) != hash_of(std::array<std::uint64_t, 2>{2, 1}));
}

}  // namespace
}  // namespace engram::bench
