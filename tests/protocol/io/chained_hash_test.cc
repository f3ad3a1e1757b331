#include "protocol/io/chained_hash.h"

#include <array>
#include <catch2/catch.hpp>
#include <string_view>

namespace engram {
namespace {

std::span<const char> bytes(std::string_view text) { return {text.data(), text.size()}; }

TEST_CASE("A chained hash is XXH3 with the hash before as the seed", "[formats]") {
  // Values of the Python package xxhash: xxh3_64_intdigest(b"", 0), (b"engram", 0), (b"more",
  // that).
  CHECK(hash_text(chain_hash(0, bytes(""))) == "2d06800538d394c2");
  const std::uint64_t one = chain_hash(0, bytes("engram"));
  CHECK(chain_hash(one, bytes("more")) != chain_hash(0, bytes("more")));
  CHECK(chain_hash(one, bytes("more")) != chain_hash(0, bytes("engrammore")));
  const std::array<float, 2> values = {1, 2};
  CHECK(chain_hash(7, std::span<const float>(values)) ==
        chain_hash(7, std::as_bytes(std::span(values))));
}

TEST_CASE("The text of a hash has 16 digits", "[formats]") {
  CHECK(hash_text(0) == "0000000000000000");
  CHECK(hash_text(0x0123456789abcdefu) == "0123456789abcdef");
}

}  // namespace
}  // namespace engram
