#include "core/base/aligned_array.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <limits>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace engram {
namespace {

bool is_aligned(const void* pointer) { return reinterpret_cast<std::uintptr_t>(pointer) % 64 == 0; }

TEST_CASE("AlignedArray starts aligned and zero, even in used memory", "[aligned_array]") {
  for (std::size_t size = 1; size < 200; size += 7) {
    for (int round = 0; round < 3; ++round) {
      AlignedArray<float> array(size);
      REQUIRE(is_aligned(array.data()));
      REQUIRE(array.size() == size);
      REQUIRE(std::ranges::count(array, 0.0f) == static_cast<std::ptrdiff_t>(size));
      std::ranges::fill(array, 3.0f);
    }
  }
}

TEST_CASE("AlignedArray may begin without values", "[aligned_array]") {
  auto array = AlignedArray<double>::uninitialized(100);
  REQUIRE(array.size() == 100);
  CHECK(is_aligned(array.data()));
  std::ranges::fill(array, 2.0);
  CHECK(array[99] == 2.0);
  CHECK(AlignedArray<double>::uninitialized(0).empty());
  CHECK_THROWS_AS(AlignedArray<double>::uninitialized(std::numeric_limits<std::size_t>::max()),
                  std::bad_array_new_length);
}

TEST_CASE("AlignedArray gives access to its elements", "[aligned_array]") {
  AlignedArray<int> array(5);
  array[3] = 7;
  array.span()[4] = 8;
  const AlignedArray<int>& view = array;
  CHECK(view[3] == 7);
  CHECK(view.span().back() == 8);
  CHECK(view.data() == array.begin());
  CHECK(view.end() - view.begin() == 5);
  CHECK_FALSE(view.empty());
}

TEST_CASE("AlignedArray moves and does not copy", "[aligned_array]") {
  STATIC_REQUIRE_FALSE(std::is_copy_constructible_v<AlignedArray<int>>);
  STATIC_REQUIRE_FALSE(std::is_copy_assignable_v<AlignedArray<int>>);
  STATIC_REQUIRE(std::is_nothrow_move_constructible_v<AlignedArray<int>>);

  AlignedArray<int> first(3);
  first[2] = 9;
  const int* const address = first.data();
  AlignedArray<int> second = std::move(first);
  CHECK(second.data() == address);
  CHECK(first.empty());  // NOLINT(bugprone-use-after-move)

  AlignedArray<int> third(10);
  third = std::move(second);
  CHECK(third.data() == address);
  CHECK(third.size() == 3);
  CHECK(third[2] == 9);

  AlignedArray<int>& alias = third;
  third = std::move(alias);
  CHECK(third.data() == address);
  CHECK(third.size() == 3);
}

TEST_CASE("AlignedArray may be empty and refuses impossible sizes", "[aligned_array]") {
  CHECK(AlignedArray<int>().empty());
  CHECK(AlignedArray<int>(0).span().empty());
  CHECK_THROWS_AS(AlignedArray<int>(std::numeric_limits<std::size_t>::max() / 2), std::bad_alloc);
}

TEST_CASE("AlignedArray respects stricter alignments and default member values",
          "[aligned_array]") {
  struct alignas(128) Wide {
    int value = 4;
  };
  const AlignedArray<Wide> array(3);
  CHECK(reinterpret_cast<std::uintptr_t>(array.data()) % 128 == 0);
  CHECK(array[2].value == 4);
}

}  // namespace
}  // namespace engram
