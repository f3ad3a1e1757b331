#include "core/batch/output_copies.h"

#include <array>
#include <catch2/catch.hpp>

namespace engram {
namespace {

std::byte* bytes(auto& values) { return reinterpret_cast<std::byte*>(values.data()); }

TEST_CASE("Rows are copied into wider ones, for the range alone") {
  const std::array<float, 6> from = {1, 2, 3, 4, 5, 6};  // 3 rows of 2
  std::array<float, 12> to{};                            // 3 rows of 4
  OutputCopies copies;
  copies.add({reinterpret_cast<const std::byte*>(from.data()), bytes(to) + 4, 8, 16, 8});
  copies.copy({1, 3}, nullptr);
  CHECK(to == std::array<float, 12>{0, 0, 0, 0, 0, 3, 4, 0, 0, 5, 6, 0});
}

TEST_CASE("Adjoining parts of a row become one copy with the same result") {
  const std::array<float, 6> from = {1, 2, 3, 4, 5, 6};  // 2 rows of 3
  std::array<float, 8> to{};                             // 2 rows of 4
  const auto* const source = reinterpret_cast<const std::byte*>(from.data());
  OutputCopies copies;
  copies.add({source, bytes(to), 12, 16, 4});
  copies.add({source + 4, bytes(to) + 4, 12, 16, 4});   // adjoins
  copies.add({source + 8, bytes(to) + 12, 12, 16, 4});  // with a gap
  copies.copy({0, 2}, nullptr);
  CHECK(to == std::array<float, 8>{1, 2, 0, 3, 4, 5, 0, 6});
}

TEST_CASE("Whole numbers become floats") {
  const std::array<std::int32_t, 4> from = {-1, 7, 1 << 20, 0};
  std::array<float, 6> to{};  // 2 rows of 3
  OutputCopies copies;
  copies.add({reinterpret_cast<const std::byte*>(from.data()), bytes(to), 8, 12, 8, true});
  copies.copy({0, 2}, nullptr);
  CHECK(to == std::array<float, 6>{-1, 7, 0, 1 << 20, 0, 0});
}

TEST_CASE("Final rows are copied where an episode has ended") {
  const std::array<float, 3> from = {1, 2, 3};
  std::array<float, 3> to{};
  const std::array<std::uint8_t, 3> mask = {0, 1, 0};
  OutputCopies copies;
  copies.add_final({reinterpret_cast<const std::byte*>(from.data()), bytes(to), 4, 4, 4});
  copies.copy({0, 3}, mask.data());
  CHECK(to == std::array<float, 3>{0, 2, 0});
}

}  // namespace
}  // namespace engram
