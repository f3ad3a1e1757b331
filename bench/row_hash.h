// Hashes of outputs, one environment's row at a time. xxHash is used as a header, without its
// library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#define XXH_INLINE_ALL
#include <xxhash.h>

namespace engram::bench {

// The hash of the rows before, continued with one environment's row of `num_envs` rows; unchanged
// where there are none.
template <class T>
std::uint64_t chain_row(std::uint64_t hash, std::span<const T> rows, std::size_t num_envs,
                        std::size_t env) {
  if (rows.empty()) return hash;
  const std::size_t width = rows.size() / num_envs;
  return XXH3_64bits_withSeed(rows.data() + env * width, width * sizeof(T), hash);
}

// One hash of all of them, in their order.
inline std::uint64_t hash_of(std::span<const std::uint64_t> hashes) {
  return XXH3_64bits(hashes.data(), hashes.size_bytes());
}

}  // namespace engram::bench
