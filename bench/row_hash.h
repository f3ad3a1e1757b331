// Hashes of outputs, one environment's row at a time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "protocol/io/chained_hash.h"

namespace engram::bench {

// The hash of the rows before, continued with one environment's row of `num_envs` rows; unchanged
// where there are none.
template <class T>
std::uint64_t chain_row(std::uint64_t hash, std::span<const T> rows, std::size_t num_envs,
                        std::size_t env) {
  if (rows.empty()) return hash;
  const std::size_t width = rows.size() / num_envs;
  return chain_hash(hash, rows.subspan(env * width, width));
}

// One hash of all of them, in their order.
inline std::uint64_t hash_of(std::span<const std::uint64_t> hashes) {
  return chain_hash(0, hashes);
}

}  // namespace engram::bench
