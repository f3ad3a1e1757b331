#include "protocol/io/chained_hash.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace engram {

std::uint64_t chain_hash(std::uint64_t hash, std::span<const std::byte> piece) {
  return XXH3_64bits_withSeed(piece.data(), piece.size(), hash);
}

std::string hash_text(std::uint64_t hash) {
  std::string text(16, '0');
  for (std::size_t i = text.size(); i-- > 0; hash >>= 4) text[i] = "0123456789abcdef"[hash & 15];
  return text;
}

}  // namespace engram
