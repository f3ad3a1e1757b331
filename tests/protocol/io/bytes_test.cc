#include "protocol/io/bytes.h"

#include <catch2/catch.hpp>
#include <string_view>
#include <vector>

namespace engram {
namespace {

TEST_CASE("Values come back from bytes in their order", "[bytes]") {
  ByteWriter out;
  out.put(std::int32_t{-5});
  out.put(2.5);
  out.put(std::string_view("word"));
  const std::vector<float> values = {1.0F, -2.0F};
  out.append(std::span<const float>(values));
  const Bytes bytes = out.take();
  ByteReader in(bytes);
  CHECK(in.get<std::int32_t>() == -5);
  CHECK(in.get<double>() == 2.5);
  CHECK(in.text() == "word");
  CHECK(in.values<float>(2) == values);
  CHECK(in.rest().empty());
  CHECK_THROWS_AS(in.get<std::uint8_t>(), Error);
  ByteReader again(bytes);
  CHECK_THROWS_AS(again.values<double>(std::size_t{1} << 61), Error);
}

TEST_CASE("Bytes are little-endian and without gaps", "[bytes]") {
  ByteWriter out;
  out.put(std::uint8_t{1});
  out.put(std::uint32_t{2});
  CHECK(out.bytes() == Bytes{std::byte{1}, std::byte{2}, std::byte{0}, std::byte{0}, std::byte{0}});
  out.clear();
  CHECK(out.bytes().empty());
}

TEST_CASE("A text longer than the message is refused", "[bytes]") {
  ByteWriter out;
  out.put(std::uint32_t{100});
  const Bytes bytes = out.take();
  CHECK_THROWS_WITH(ByteReader(bytes).text(), Catch::Contains("100 needed"));
}

}  // namespace
}  // namespace engram
