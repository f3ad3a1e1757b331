#include "core/base/checksum.h"

#include <array>
#include <catch2/catch.hpp>

namespace engram {
namespace {

TEST_CASE("The checksum is FNV-1a of 64 bits, by its published values", "[checksum]") {
  CHECK(checksum("") == 0xcbf29ce484222325u);
  CHECK(checksum("a") == 0xaf63dc4c8601ec8cu);
  CHECK(checksum("foobar") == 0x85944171f73967e8u);
}

TEST_CASE("A checksum goes on from that of an earlier part", "[checksum]") {
  CHECK(checksum("bar", checksum("foo")) == checksum("foobar"));
}

TEST_CASE("Bytes have the checksum of their text, also above 127", "[checksum]") {
  const std::array bytes = {std::byte{'f'}, std::byte{0xff}, std::byte{0}};
  CHECK(checksum(bytes) == checksum(std::string_view("f\xff\0", 3)));
  std::array damaged = bytes;
  damaged[2] = std::byte{1};
  CHECK(checksum(damaged) != checksum(bytes));
}

}  // namespace
}  // namespace engram
