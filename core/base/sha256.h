// SHA-256 (FIPS 180-4), for commitments to secrets and numbers that reveal none.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

namespace engram {

using Sha256 = std::array<std::uint8_t, 32>;

Sha256 sha256(std::string_view bytes);
// The first eight bytes as a number, the first byte being the highest.
std::uint64_t leading_number(const Sha256& digest);
// 64 lower-case digits, as `sha256sum` prints them.
std::string to_hex(const Sha256& digest);

}  // namespace engram
