// Vectors of floats for the ray caster's kernels: the widest of the instruction set at hand.
//
// Kernels live in unnamed namespaces and call nothing of the standard library, so that the linker
// cannot merge code compiled for a wide instruction set into code that runs everywhere. All
// operations are exactly rounded ones, so that instruction sets agree to the last bit.
#pragma once

#include <cstdint>

#include "core/base/intrinsics.h"

#define ENGRAM_INLINE [[maybe_unused]] inline __attribute__((always_inline))

namespace engram::cpu {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16;
#elif defined(__AVX2__)
constexpr int kLanes = 8;
#else
constexpr int kLanes = 4;
#endif

using Float = float __attribute__((vector_size(4 * kLanes)));
using Int = std::int32_t __attribute__((vector_size(4 * kLanes)));

// Memory is aligned to whole vectors.
ENGRAM_INLINE Float load(const float* from) {
  Float value;
  __builtin_memcpy(&value, __builtin_assume_aligned(from, sizeof(Float)), sizeof value);
  return value;
}
ENGRAM_INLINE Int load(const std::int32_t* from) {
  Int value;
  __builtin_memcpy(&value, __builtin_assume_aligned(from, sizeof(Int)), sizeof value);
  return value;
}
ENGRAM_INLINE void store(float* to, Float value) {
  __builtin_memcpy(__builtin_assume_aligned(to, sizeof value), &value, sizeof value);
}
template <typename Word>
ENGRAM_INLINE void store(Word* to, Int value) {
  __builtin_memcpy(__builtin_assume_aligned(to, sizeof value), &value, sizeof value);
}

// The same anywhere.
ENGRAM_INLINE Float load_anywhere(const float* from) {
  Float value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
ENGRAM_INLINE Int load_anywhere(const std::int32_t* from) {
  Int value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
ENGRAM_INLINE void store_anywhere(float* to, Float value) {
  __builtin_memcpy(to, &value, sizeof value);
}
ENGRAM_INLINE void store_anywhere(std::int32_t* to, Int value) {
  __builtin_memcpy(to, &value, sizeof value);
}

ENGRAM_INLINE Float splat(float value) { return value - Float{}; }
ENGRAM_INLINE Int splat(std::int32_t value) { return value - Int{}; }
ENGRAM_INLINE Float to_float(Int a) { return __builtin_convertvector(a, Float); }
ENGRAM_INLINE Int truncate(Float a) { return __builtin_convertvector(a, Int); }

#if defined(__AVX512F__)

struct Mask {
  __mmask16 bits;
};
ENGRAM_INLINE Mask make_mask(int bits) { return {static_cast<__mmask16>(bits)}; }
ENGRAM_INLINE Mask operator&(Mask a, Mask b) { return make_mask(a.bits & b.bits); }
ENGRAM_INLINE Mask operator|(Mask a, Mask b) { return make_mask(a.bits | b.bits); }
ENGRAM_INLINE Mask without(Mask a, Mask b) { return make_mask(a.bits & ~b.bits); }
ENGRAM_INLINE Mask less(Float a, Float b) {
  return {_mm512_cmp_ps_mask(__m512(a), __m512(b), _CMP_LT_OQ)};
}
ENGRAM_INLINE Mask at_most(Float a, Float b) {
  return {_mm512_cmp_ps_mask(__m512(a), __m512(b), _CMP_LE_OQ)};
}
ENGRAM_INLINE Mask equal(Int a, Int b) { return {_mm512_cmpeq_epi32_mask(__m512i(a), __m512i(b))}; }
ENGRAM_INLINE Mask negative(Int a) { return {_mm512_movepi32_mask(__m512i(a))}; }
ENGRAM_INLINE int bits(Mask m) { return m.bits; }
ENGRAM_INLINE Float select(Mask m, Float a, Float b) {
  return Float(_mm512_mask_blend_ps(m.bits, __m512(b), __m512(a)));
}
ENGRAM_INLINE Int select(Mask m, Int a, Int b) {
  return Int(_mm512_mask_blend_epi32(m.bits, __m512i(b), __m512i(a)));
}
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm512_min_ps(__m512(a), __m512(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm512_max_ps(__m512(a), __m512(b))); }
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm512_sqrt_ps(__m512(a))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm512_cvtps_epi32(__m512(a))); }

#else

struct Mask {
  Int lanes;  // all bits or none
};
ENGRAM_INLINE Mask operator&(Mask a, Mask b) { return {a.lanes & b.lanes}; }
ENGRAM_INLINE Mask operator|(Mask a, Mask b) { return {a.lanes | b.lanes}; }
ENGRAM_INLINE Mask without(Mask a, Mask b) { return {a.lanes & ~b.lanes}; }
ENGRAM_INLINE Mask less(Float a, Float b) { return {a < b}; }
ENGRAM_INLINE Mask at_most(Float a, Float b) { return {a <= b}; }
ENGRAM_INLINE Mask equal(Int a, Int b) { return {a == b}; }
ENGRAM_INLINE Mask negative(Int a) { return {a < 0}; }

#if defined(__AVX2__)

ENGRAM_INLINE int bits(Mask m) { return _mm256_movemask_ps(__m256(m.lanes)); }
ENGRAM_INLINE Float select(Mask m, Float a, Float b) {
  return Float(_mm256_blendv_ps(__m256(b), __m256(a), __m256(m.lanes)));
}
ENGRAM_INLINE Int select(Mask m, Int a, Int b) {
  return Int(_mm256_blendv_epi8(__m256i(b), __m256i(a), __m256i(m.lanes)));
}
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm256_min_ps(__m256(a), __m256(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm256_max_ps(__m256(a), __m256(b))); }
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm256_sqrt_ps(__m256(a))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm256_cvtps_epi32(__m256(a))); }

#else

ENGRAM_INLINE Int select(Mask m, Int a, Int b) { return (a & m.lanes) | (b & ~m.lanes); }
ENGRAM_INLINE Float select(Mask m, Float a, Float b) { return Float(select(m, Int(a), Int(b))); }

#if defined(__SSE2__)

ENGRAM_INLINE int bits(Mask m) { return _mm_movemask_ps(__m128(m.lanes)); }
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm_min_ps(__m128(a), __m128(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm_max_ps(__m128(a), __m128(b))); }
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm_sqrt_ps(__m128(a))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm_cvtps_epi32(__m128(a))); }

#else

ENGRAM_INLINE int bits(Mask m) {
  return (m.lanes[0] & 1) | (m.lanes[1] & 2) | (m.lanes[2] & 4) | (m.lanes[3] & 8);
}
ENGRAM_INLINE Float min(Float a, Float b) { return select(less(a, b), a, b); }
ENGRAM_INLINE Float max(Float a, Float b) { return select(less(b, a), a, b); }
ENGRAM_INLINE Float sqrt(Float a) {
  return Float{__builtin_sqrtf(a[0]), __builtin_sqrtf(a[1]), __builtin_sqrtf(a[2]),
               __builtin_sqrtf(a[3])};
}
// To the nearest, for magnitudes below 2^22: adding 1.5 * 2^23 leaves no bits for a fraction.
ENGRAM_INLINE Int round(Float a) { return truncate((a + 12582912.0F) - 12582912.0F); }

#endif
#endif
#endif

ENGRAM_INLINE bool any(Mask m) { return bits(m) != 0; }
ENGRAM_INLINE bool all(Mask m) { return bits(m) == (1 << kLanes) - 1; }
ENGRAM_INLINE Float abs(Float a) { return Float(Int(a) & 0x7fffffff); }
ENGRAM_INLINE Float clamp(Float a, float low, float high) {
  return min(max(a, splat(low)), splat(high));
}

// Bytes at these offsets; up to three bytes beyond each are read.
ENGRAM_INLINE Int gather_bytes(const std::uint8_t* from, Int offsets) {
#if defined(__AVX512F__)
  const auto every = static_cast<__mmask16>(0xffff);
  return Int(_mm512_mask_i32gather_epi32(_mm512_setzero_si512(), every, __m512i(offsets), from,
                                         1)) &
         0xff;
#elif defined(__AVX2__)
  return Int(_mm256_i32gather_epi32(reinterpret_cast<const int*>(from), __m256i(offsets), 1)) &
         0xff;
#else
  return Int{from[offsets[0]], from[offsets[1]], from[offsets[2]], from[offsets[3]]};
#endif
}

}  // namespace
}  // namespace engram::cpu
