// Kernel, last part: colours into images that two cameras share, whose pixels are six bytes apart.
// Included by cpu_kernel_*.cc only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {
namespace {

using namespace simd;

#if defined(__AVX512BW__)

// Source of each 16-bit half of the image: a half of the colours. Every third one has bytes of the
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

// Source of each 16-bit half if both cameras' pixels are interleaved. The second one's have
// been rotated to 0x_brg: green and red, then blue on its own. Halves of the first one are
// 0 to 31, of the second one 32 to 63.
struct Interleave {
  alignas(64) std::uint16_t from[4][32];
};
constexpr Interleave make_interleave() {
  Interleave interleave = {};
  const auto half = [](int to) {
    const int pixel = to / 3;
    const int part = to % 3;
    return static_cast<std::uint16_t>(part == 0 ? 2 * pixel : 32 + 2 * pixel + part - 1);
  };
  // Vectors of the result: the first sixteen pixels' halves 0 to 31, 32 to 47; then the others'.
  for (int i = 0; i < 32; ++i) interleave.from[0][i] = half(i);
  for (int i = 0; i < 16; ++i) interleave.from[1][i] = half(32 + i);
  for (int i = 16; i < 32; ++i) interleave.from[2][i] = half(i - 16);
  for (int i = 0; i < 32; ++i) interleave.from[3][i] = half(16 + i);
  return interleave;
}

// Blue of the first camera below red of the second, then that one's green and blue.
ENGRAM_INLINE __m512i tail_of(__m512i first, __m512i second) {
  return _mm512_or_si512(_mm512_srli_epi32(first, 16), _mm512_slli_epi32(second, 8));
}

void store_both(const TileRow& first, const TileRow& second, int y, int count, std::uint8_t* out) {
  static_assert(kBlock == 16);
  static constexpr Interleave kInterleave = make_interleave();
  __m512i interleave[4];
  for (int i = 0; i < 4; ++i) interleave[i] = _mm512_load_si512(kInterleave.from[i]);
  int tile = 0;
  for (; (tile + 2) * kBlock <= count; tile += 2, out += 12 * kBlock) {
    __m512i head[2];
    __m512i tail[2];
    for (int i = 0; i < 2; ++i) {
      const int k = tile + i;
      head[i] = _mm512_loadu_si512(first.source[k] + y * first.stride[k]);
      tail[i] = tail_of(head[i], _mm512_loadu_si512(second.source[k] + y * second.stride[k]));
    }
    const __m512i middle = _mm512_mask_blend_epi16(
        0xffff0000U, _mm512_permutex2var_epi16(head[0], interleave[1], tail[0]),
        _mm512_permutex2var_epi16(head[1], interleave[2], tail[1]));
    _mm512_storeu_si512(out, _mm512_permutex2var_epi16(head[0], interleave[0], tail[0]));
    _mm512_storeu_si512(out + 64, middle);
    _mm512_storeu_si512(out + 128, _mm512_permutex2var_epi16(head[1], interleave[3], tail[1]));
  }
  for (int x = tile * kBlock; x < count; ++x, out += 6) {
    store_color(first.source[x / kBlock][y * first.stride[x / kBlock] + x % kBlock], out);
    store_color(second.source[x / kBlock][y * second.stride[x / kBlock] + x % kBlock], out + 3);
  }
}

#else

void store_both(const TileRow& first, const TileRow& second, int y, int count, std::uint8_t* out) {
  for (int x = 0; x < count; x += kBlock) {
    const int tile = x / kBlock;
    const std::uint32_t* a = first.source[tile] + y * first.stride[tile];
    const std::uint32_t* b = second.source[tile] + y * second.stride[tile];
    const int pixels = count - x < kBlock ? count - x : kBlock;
    for (int i = 0; i < pixels; ++i, out += 6) {
      const std::uint64_t both = a[i] | static_cast<std::uint64_t>(b[i]) << 24;
      if (x + i + 1 < count) {
        __builtin_memcpy(out, &both, 8);  // the next pixel overwrites the last two bytes
      } else {
        store_color(a[i], out);
        store_color(b[i], out + 3);
      }
    }
  }
}

void store_pairs(const std::uint32_t* colors, int count, std::uint8_t* out) {
  for (int x = 0; x < count; ++x, out += 6) store_color(colors[x], out);
}

#endif

}  // namespace
}  // namespace engram::cpu
