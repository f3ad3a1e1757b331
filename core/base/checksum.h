// Checksum of byte buffers (FNV-1a, 64 bits), which detects damaged and foreign ones.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace engram {

inline constexpr std::uint64_t kChecksumSeed = 0xcbf29ce484222325u;

constexpr std::uint64_t checksum(std::string_view text, std::uint64_t hash = kChecksumSeed) {
  for (const char c : text) {
    hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  return hash;
}

inline std::uint64_t checksum(std::span<const std::byte> bytes,
                              std::uint64_t hash = kChecksumSeed) {
  return checksum(std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
                  hash);
}

}  // namespace engram
