// Vectors of doubles for the ray caster's set-up: half as many as there are floats in one of
// cpu_simd.h, and by the same rules.
#pragma once

#include <cstdint>

#include "render/cpu_simd.h"

namespace engram::cpu {
namespace {

constexpr int kDoubles = kLanes / 2;
using Double = double __attribute__((vector_size(8 * kDoubles)));

// min, max and clamp are those of the standard library, also for zeros of either sign.
ENGRAM_INLINE Double splat_double(double value) { return value - Double{}; }
ENGRAM_INLINE Double min_of(Double a, Double b) { return b < a ? b : a; }
ENGRAM_INLINE Double max_of(Double a, Double b) { return a < b ? b : a; }
ENGRAM_INLINE Double clamp_to(Double a, double low, double high) {
  return min_of(max_of(a, splat_double(low)), splat_double(high));
}
ENGRAM_INLINE Double magnitude(Double a) { return a < 0.0 ? -a : a; }

ENGRAM_INLINE Double square_root(Double a) {
#if defined(__AVX512F__)
  return Double(_mm512_sqrt_pd(__m512d(a)));
#elif defined(__AVX2__)
  return Double(_mm256_sqrt_pd(__m256d(a)));
#elif defined(__SSE2__)
  return Double(_mm_sqrt_pd(__m128d(a)));
#else
  return Double{__builtin_sqrt(a[0]), __builtin_sqrt(a[1])};
#endif
}

ENGRAM_INLINE Double load(const double* from) {
  Double value;
  __builtin_memcpy(&value, __builtin_assume_aligned(from, sizeof value), sizeof value);
  return value;
}
ENGRAM_INLINE void store(float* to, Double value) {
  using Narrow = float __attribute__((vector_size(4 * kDoubles)));
  const Narrow narrow = __builtin_convertvector(value, Narrow);
  __builtin_memcpy(to, &narrow, sizeof narrow);
}
// Cuts fractions off.
ENGRAM_INLINE void store(std::int32_t* to, Double value) {
  using Narrow = std::int32_t __attribute__((vector_size(4 * kDoubles)));
  const Narrow narrow = __builtin_convertvector(value, Narrow);
  __builtin_memcpy(to, &narrow, sizeof narrow);
}
// Magnitudes below 2^31.
ENGRAM_INLINE Double cut_off(Double a) {
  using Narrow = std::int32_t __attribute__((vector_size(4 * kDoubles)));
  return __builtin_convertvector(__builtin_convertvector(a, Narrow), Double);
}
ENGRAM_INLINE Double round_down(Double a) {
  const Double whole = cut_off(a);
  return whole - (a < whole ? splat_double(1) : Double{});
}
ENGRAM_INLINE Double round_up(Double a) {
  const Double whole = cut_off(a);
  return whole + (whole < a ? splat_double(1) : Double{});
}

}  // namespace
}  // namespace engram::cpu
