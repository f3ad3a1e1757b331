// Kernel, last part: colours into images that two cameras share, whose pixels are six bytes apart.
// Included by cpu_kernel_*.cc only.
#pragma once

#include "render/cpu_frame.h"
#include "render/cpu_simd.h"

namespace engram::cpu {
namespace {

#if defined(__AVX512BW__)

// Which 16-bit half of the colours goes to each half of the image. Every third one has bytes of the
// other camera.
struct Halves {
  alignas(64) std::uint16_t from[64];
};
constexpr Halves make_halves() {
  Halves halves = {};
  for (int to = 0; to < 64; ++to) {
    halves.from[to] = static_cast<std::uint16_t>((2 * (to / 3) + to % 3) & 31);
  }
  return halves;
}

constexpr std::uint64_t ours(int first_byte) {
  std::uint64_t mask = 0;
  for (int byte = 0; byte < 64; ++byte) {
    if ((first_byte + byte) % 6 < 3) mask |= std::uint64_t{1} << byte;
  }
  return mask;
}

void store_pairs(const std::uint32_t* colors, int count, std::uint8_t* out) {
  static constexpr Halves kHalves = make_halves();
  constexpr std::uint64_t kFirst = ours(0);
  constexpr std::uint64_t kSecond = ours(64) & 0xffffffff;
  const __m512i first = _mm512_load_si512(kHalves.from);
  const __m512i second = _mm512_load_si512(kHalves.from + 32);
  int x = 0;
  for (; x + 16 <= count; x += 16, out += 96) {
    const __m512i pixels = _mm512_loadu_si512(colors + x);
    _mm512_mask_storeu_epi8(out, kFirst, _mm512_permutexvar_epi16(first, pixels));
    _mm512_mask_storeu_epi8(out + 64, kSecond, _mm512_permutexvar_epi16(second, pixels));
  }
  for (; x < count; ++x, out += 6) store_color(colors[x], out);
}

#else

void store_pairs(const std::uint32_t* colors, int count, std::uint8_t* out) {
  for (int x = 0; x < count; ++x, out += 6) store_color(colors[x], out);
}

#endif

}  // namespace
}  // namespace engram::cpu
