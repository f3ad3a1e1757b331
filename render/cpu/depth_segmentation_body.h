// Kernel, last part: depths and segments into images of 16-bit numbers. Included by cpu_kernel_*.cc
// only.
#pragma once

#include "core/math/simd.h"
#include "render/cpu/frame_data.h"

namespace engram::cpu {
namespace {

using namespace simd;

constexpr float kMaxMillimetres = 32767;

// The background has the w of the far end.
ENGRAM_INLINE Int millimetres(Float w, float far_w) {
  const Int nearest = round(min(1000.0F / w, broadcast(kMaxMillimetres)));
  return select(less(broadcast(far_w), w), nearest, Int{});
}

ENGRAM_INLINE Int depths(const TileRow& row, float far_w, int tile, int y, int x) {
  return millimetres(load_unaligned(row.w_source[tile] + y * row.stride[tile] + x), far_w);
}

ENGRAM_INLINE Int segments(const TileRow& row, int tile, int y, int x) {
  const std::uint32_t* at = row.source[tile] + y * row.stride[tile] + x;
  return load_unaligned(reinterpret_cast<const std::int32_t*>(at));
}

// Stores one camera's values. `values` finds those of a vector of columns of a tile.
template <typename Values>
ENGRAM_INLINE void store_values(int count, std::ptrdiff_t step, std::int16_t* out, Values values) {
  for (int x = 0; x < count; x += kBlock) {
    alignas(64) std::int32_t here[kBlock];
    for (int part = 0; part < kBlock; part += kFloats) store(here + part, values(x / kBlock, part));
    const int pixels = count - x < kBlock ? count - x : kBlock;
    for (int i = 0; i < pixels; ++i, out += step) *out = static_cast<std::int16_t>(here[i]);
  }
}

// Stores two cameras' values, which are the halves of words.
template <typename Values>
ENGRAM_INLINE void store_words(int count, std::int16_t* out, Values values) {
  for (int x = 0; x < count; x += kFloats, out += 2 * kFloats) {
    const Int words = values(x / kBlock, x % kBlock);
    const int pixels = count - x < kFloats ? count - x : kFloats;
    if (pixels == kFloats) {
      __builtin_memcpy(out, &words, sizeof words);
    } else {
      __builtin_memcpy(out, &words, static_cast<std::size_t>(pixels) * sizeof words[0]);
    }
  }
}

void store_depths(const TileRow& row, float far_w, int y, int count, std::ptrdiff_t step,
                  std::int16_t* out) {
  store_values(
      count, step, out, [&](int tile, int x) __attribute__((always_inline)) {
        return depths(row, far_w, tile, y, x);
      });
}

void store_segments(const TileRow& row, int y, int count, std::ptrdiff_t step, std::int16_t* out) {
  store_values(
      count, step, out, [&](int tile, int x) __attribute__((always_inline)) {
        return segments(row, tile, y, x);
      });
}

void store_both_depths(const TileRow& first, const TileRow& second, const float* far_w, int y,
                       int count, std::int16_t* out) {
  store_words(
      count, out, [&](int tile, int x) __attribute__((always_inline)) {
        return depths(first, far_w[0], tile, y, x) | depths(second, far_w[1], tile, y, x) << 16;
      });
}

void store_both_segments(const TileRow& first, const TileRow& second, int y, int count,
                         std::int16_t* out) {
  store_words(
      count, out, [&](int tile, int x) __attribute__((always_inline)) {
        return segments(first, tile, y, x) | segments(second, tile, y, x) << 16;
      });
}

}  // namespace
}  // namespace engram::cpu
