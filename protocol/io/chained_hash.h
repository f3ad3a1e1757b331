// Hashes of data that come piece by piece.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace engram {

// XXH3 (64 bits) of a piece, with the hash of the pieces before it as the seed; 0 at first.
std::uint64_t chain_hash(std::uint64_t hash, std::span<const std::byte> piece);

template <class T>
std::uint64_t chain_hash(std::uint64_t hash, std::span<const T> piece) {
  return chain_hash(hash, std::as_bytes(piece));
}

// 16 lower-case digits.
std::string hash_text(std::uint64_t hash);

}  // namespace engram
