// Vectors of floats, integers and doubles, as wide as the instruction set at hand has them, for the
// kernels of physics and of the ray caster.
//
// A kernel's file is compiled once per instruction set. Everything inline that such files share
// lives in a namespace of the instruction set (ENGRAM_ISA) and calls nothing of the standard
// library, so that the linker cannot merge code compiled for a wide instruction set into code that
// runs everywhere. All operations are exactly rounded ones, so instruction sets agree to the last
// bit, and so does a single number.
#pragma once

#include <cstdint>
#include <type_traits>

#if defined(__SSE2__)
#if defined(__GNUC__) && !defined(__clang__)
// GCC 12 warns of undefined vectors in its own AVX-512 header.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <immintrin.h>
#pragma GCC diagnostic pop
#else
#include <immintrin.h>
#endif
#endif

#define ENGRAM_INLINE [[maybe_unused]] inline __attribute__((always_inline))

#if defined(__AVX512F__)
#define ENGRAM_ISA isa_avx512
#elif defined(__AVX2__)
#define ENGRAM_ISA isa_avx2
#else
#define ENGRAM_ISA isa_baseline
#endif

namespace engram::simd {
inline namespace ENGRAM_ISA {

#if defined(__AVX512F__)
constexpr int kFloats = 16;
#elif defined(__AVX2__)
constexpr int kFloats = 8;
#else
constexpr int kFloats = 4;
#endif
constexpr int kDoubles = kFloats / 2;

using Float = float __attribute__((vector_size(4 * kFloats)));
using Int = std::int32_t __attribute__((vector_size(4 * kFloats)));
using Double = double __attribute__((vector_size(8 * kDoubles)));
using FloatMask = decltype(Float{} < Float{});
using DoubleMask = decltype(Double{} < Double{});

// Type of the numbers of a V. V: Float, Double, or a single float or double, for which the
// functions below exist as well.
template <class V>
struct ScalarTrait {
  using Type = V;
};
template <>
struct ScalarTrait<Float> {
  using Type = float;
};
template <>
struct ScalarTrait<Double> {
  using Type = double;
};
template <class V>
using ScalarOf = typename ScalarTrait<V>::Type;
template <class V>
constexpr int kLanesOf = sizeof(V) / sizeof(ScalarOf<V>);

// --- memory ---

// Aligned to whole vectors.
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
ENGRAM_INLINE Double load(const double* from) {
  Double value;
  __builtin_memcpy(&value, __builtin_assume_aligned(from, sizeof value), sizeof value);
  return value;
}
ENGRAM_INLINE void store(float* to, Float value) {
  __builtin_memcpy(__builtin_assume_aligned(to, sizeof value), &value, sizeof value);
}
template <typename Word>
ENGRAM_INLINE void store(Word* to, Int value) {
  __builtin_memcpy(__builtin_assume_aligned(to, sizeof value), &value, sizeof value);
}

// Anywhere.
ENGRAM_INLINE Float load_unaligned(const float* from) {
  Float value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
ENGRAM_INLINE Int load_unaligned(const std::int32_t* from) {
  Int value;
  __builtin_memcpy(&value, from, sizeof value);
  return value;
}
ENGRAM_INLINE void store_unaligned(float* to, Float value) {
  __builtin_memcpy(to, &value, sizeof value);
}
ENGRAM_INLINE void store_unaligned(std::int32_t* to, Int value) {
  __builtin_memcpy(to, &value, sizeof value);
}

// Half as wide: rounded to floats, or cut off to integers. Anywhere.
ENGRAM_INLINE void store(float* to, Double value) {
  using Narrow = float __attribute__((vector_size(4 * kDoubles)));
  const Narrow narrow = __builtin_convertvector(value, Narrow);
  __builtin_memcpy(to, &narrow, sizeof narrow);
}
ENGRAM_INLINE void store(std::int32_t* to, Double value) {
  using Narrow = std::int32_t __attribute__((vector_size(4 * kDoubles)));
  const Narrow narrow = __builtin_convertvector(value, Narrow);
  __builtin_memcpy(to, &narrow, sizeof narrow);
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

// --- the same number in all lanes, and conversions ---

template <class V>
ENGRAM_INLINE V broadcast(ScalarOf<V> value) {
  return value - V{};
}
ENGRAM_INLINE Float broadcast(float value) { return value - Float{}; }
ENGRAM_INLINE Int broadcast(std::int32_t value) { return value - Int{}; }
ENGRAM_INLINE Float to_float(Int a) { return __builtin_convertvector(a, Float); }
ENGRAM_INLINE Int truncate(Float a) { return __builtin_convertvector(a, Int); }
// Magnitudes below 2^31.
ENGRAM_INLINE Double truncate(Double a) {
  using Narrow = std::int32_t __attribute__((vector_size(4 * kDoubles)));
  return __builtin_convertvector(__builtin_convertvector(a, Narrow), Double);
}

// --- comparisons of floats and integers ---

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
#else
#if defined(__SSE2__)
ENGRAM_INLINE int bits(Mask m) { return _mm_movemask_ps(__m128(m.lanes)); }
#else
ENGRAM_INLINE int bits(Mask m) {
  return (m.lanes[0] & 1) | (m.lanes[1] & 2) | (m.lanes[2] & 4) | (m.lanes[3] & 8);
}
#endif
ENGRAM_INLINE Int select(Mask m, Int a, Int b) { return (a & m.lanes) | (b & ~m.lanes); }
ENGRAM_INLINE Float select(Mask m, Float a, Float b) { return Float(select(m, Int(a), Int(b))); }
#endif

#endif

ENGRAM_INLINE bool any(Mask m) { return bits(m) != 0; }
ENGRAM_INLINE bool all(Mask m) { return bits(m) == (1 << kFloats) - 1; }

// --- comparisons by operators: a < b and the like give a bool, a FloatMask or a DoubleMask ---

ENGRAM_INLINE unsigned bits(bool mask) { return mask ? 1U : 0U; }
ENGRAM_INLINE unsigned bits(FloatMask mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask(__m512i(mask));
#else
  return static_cast<unsigned>(bits(Mask{mask}));
#endif
}
ENGRAM_INLINE unsigned bits(DoubleMask mask) {
#if defined(__AVX512F__)
  return _mm512_movepi64_mask(__m512i(mask));
#elif defined(__AVX2__)
  return static_cast<unsigned>(_mm256_movemask_pd(__m256d(mask)));
#elif defined(__SSE2__)
  return static_cast<unsigned>(_mm_movemask_pd(__m128d(mask)));
#else
  return bits(mask[0] != 0) | bits(mask[1] != 0) << 1U;
#endif
}
ENGRAM_INLINE bool any(bool mask) { return mask; }
ENGRAM_INLINE bool any(FloatMask mask) { return bits(mask) != 0; }
ENGRAM_INLINE bool any(DoubleMask mask) { return bits(mask) != 0; }
ENGRAM_INLINE bool logical_or(bool a, bool b) { return a || b; }
ENGRAM_INLINE bool logical_and(bool a, bool b) { return a && b; }
ENGRAM_INLINE FloatMask logical_or(FloatMask a, FloatMask b) { return a | b; }
ENGRAM_INLINE FloatMask logical_and(FloatMask a, FloatMask b) { return a & b; }
ENGRAM_INLINE DoubleMask logical_or(DoubleMask a, DoubleMask b) { return a | b; }
ENGRAM_INLINE DoubleMask logical_and(DoubleMask a, DoubleMask b) { return a & b; }

// --- arithmetic ---

// min and max give the first if it is less (greater) than the second; so the second if one is NaN.
ENGRAM_INLINE float sqrt(float a) { return __builtin_sqrtf(a); }
ENGRAM_INLINE float min(float a, float b) { return a < b ? a : b; }
ENGRAM_INLINE float max(float a, float b) { return a > b ? a : b; }
ENGRAM_INLINE double sqrt(double a) { return __builtin_sqrt(a); }
ENGRAM_INLINE double min(double a, double b) { return a < b ? a : b; }
ENGRAM_INLINE double max(double a, double b) { return a > b ? a : b; }

#if defined(__AVX512F__)
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm512_sqrt_ps(__m512(a))); }
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm512_min_ps(__m512(a), __m512(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm512_max_ps(__m512(a), __m512(b))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm512_cvtps_epi32(__m512(a))); }
ENGRAM_INLINE Double sqrt(Double a) { return Double(_mm512_sqrt_pd(__m512d(a))); }
ENGRAM_INLINE Double min(Double a, Double b) {
  return Double(_mm512_min_pd(__m512d(a), __m512d(b)));
}
ENGRAM_INLINE Double max(Double a, Double b) {
  return Double(_mm512_max_pd(__m512d(a), __m512d(b)));
}
#elif defined(__AVX2__)
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm256_sqrt_ps(__m256(a))); }
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm256_min_ps(__m256(a), __m256(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm256_max_ps(__m256(a), __m256(b))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm256_cvtps_epi32(__m256(a))); }
ENGRAM_INLINE Double sqrt(Double a) { return Double(_mm256_sqrt_pd(__m256d(a))); }
ENGRAM_INLINE Double min(Double a, Double b) {
  return Double(_mm256_min_pd(__m256d(a), __m256d(b)));
}
ENGRAM_INLINE Double max(Double a, Double b) {
  return Double(_mm256_max_pd(__m256d(a), __m256d(b)));
}
#elif defined(__SSE2__)
ENGRAM_INLINE Float sqrt(Float a) { return Float(_mm_sqrt_ps(__m128(a))); }
ENGRAM_INLINE Float min(Float a, Float b) { return Float(_mm_min_ps(__m128(a), __m128(b))); }
ENGRAM_INLINE Float max(Float a, Float b) { return Float(_mm_max_ps(__m128(a), __m128(b))); }
ENGRAM_INLINE Int round(Float a) { return Int(_mm_cvtps_epi32(__m128(a))); }
ENGRAM_INLINE Double sqrt(Double a) { return Double(_mm_sqrt_pd(__m128d(a))); }
ENGRAM_INLINE Double min(Double a, Double b) { return Double(_mm_min_pd(__m128d(a), __m128d(b))); }
ENGRAM_INLINE Double max(Double a, Double b) { return Double(_mm_max_pd(__m128d(a), __m128d(b))); }
#else
ENGRAM_INLINE Float sqrt(Float a) {
  return Float{__builtin_sqrtf(a[0]), __builtin_sqrtf(a[1]), __builtin_sqrtf(a[2]),
               __builtin_sqrtf(a[3])};
}
ENGRAM_INLINE Float min(Float a, Float b) { return select(less(a, b), a, b); }
ENGRAM_INLINE Float max(Float a, Float b) { return select(less(b, a), a, b); }
// To the nearest, for magnitudes below 2^22: adding 1.5 * 2^23 leaves no bits for a fraction.
ENGRAM_INLINE Int round(Float a) { return truncate((a + 12582912.0F) - 12582912.0F); }
ENGRAM_INLINE Double sqrt(Double a) { return Double{sqrt(a[0]), sqrt(a[1])}; }
ENGRAM_INLINE Double min(Double a, Double b) { return a < b ? a : b; }
ENGRAM_INLINE Double max(Double a, Double b) { return a > b ? a : b; }
#endif

ENGRAM_INLINE float abs(float a) { return __builtin_fabsf(a); }
ENGRAM_INLINE Float abs(Float a) { return Float(Int(a) & 0x7fffffff); }
template <class V>  // double or Double
ENGRAM_INLINE V abs(V a) {
  return max(a, -a);
}
template <class V>
ENGRAM_INLINE V clamp(V a, ScalarOf<V> low, ScalarOf<V> high) {
  return min(broadcast<V>(high), max(broadcast<V>(low), a));
}

// Magnitudes below 2^31.
ENGRAM_INLINE Double floor(Double a) {
  const Double whole = truncate(a);
  return whole - (a < whole ? broadcast<Double>(1) : Double{});
}
ENGRAM_INLINE Double ceil(Double a) {
  const Double whole = truncate(a);
  return whole + (whole < a ? broadcast<Double>(1) : Double{});
}

// --- doubles beside floats ---

// A Double for each half of a Float's lanes.
struct DoublePair {
  Double low, high;

  ENGRAM_INLINE friend DoublePair operator+(DoublePair a, DoublePair b) {
    return {a.low + b.low, a.high + b.high};
  }
  ENGRAM_INLINE friend DoublePair operator-(DoublePair a, DoublePair b) {
    return {a.low - b.low, a.high - b.high};
  }
  ENGRAM_INLINE friend DoublePair operator+(DoublePair a, double b) {
    return {a.low + b, a.high + b};
  }
  ENGRAM_INLINE friend DoublePair operator-(DoublePair a, double b) {
    return {a.low - b, a.high - b};
  }
  ENGRAM_INLINE friend DoublePair operator-(double a, DoublePair b) {
    return {a - b.low, a - b.high};
  }
  ENGRAM_INLINE friend DoublePair operator*(double a, DoublePair b) {
    return {a * b.low, a * b.high};
  }
};
ENGRAM_INLINE DoublePair clamp(DoublePair a, double low, double high) {
  return {clamp(a.low, low, high), clamp(a.high, low, high)};
}
// As many doubles as V has lanes. V: float or Float.
template <class V>
using DoublesOf = std::conditional_t<kLanesOf<V> == 1, double, DoublePair>;

// Rounds to V. V: float or Float.
ENGRAM_INLINE float to_floats(double a) { return static_cast<float>(a); }
ENGRAM_INLINE Float to_floats(DoublePair a) {
#if defined(__AVX512F__)
  const __m512 low = _mm512_castps256_ps512(_mm512_cvtpd_ps(__m512d(a.low)));
  return Float(_mm512_insertf32x8(low, _mm512_cvtpd_ps(__m512d(a.high)), 1));
#elif defined(__AVX2__)
  const __m256 low = _mm256_castps128_ps256(_mm256_cvtpd_ps(__m256d(a.low)));
  return Float(_mm256_insertf128_ps(low, _mm256_cvtpd_ps(__m256d(a.high)), 1));
#elif defined(__SSE2__)
  return Float(_mm_movelh_ps(_mm_cvtpd_ps(__m128d(a.low)), _mm_cvtpd_ps(__m128d(a.high))));
#else
  return Float{to_floats(a.low[0]), to_floats(a.low[1]), to_floats(a.high[0]),
               to_floats(a.high[1])};
#endif
}
ENGRAM_INLINE double to_doubles(float a) { return a; }
ENGRAM_INLINE DoublePair to_doubles(Float a) {
#if defined(__AVX512F__)
  return {Double(_mm512_cvtps_pd(_mm512_castps512_ps256(__m512(a)))),
          Double(_mm512_cvtps_pd(_mm512_extractf32x8_ps(__m512(a), 1)))};
#elif defined(__AVX2__)
  return {Double(_mm256_cvtps_pd(_mm256_castps256_ps128(__m256(a)))),
          Double(_mm256_cvtps_pd(_mm256_extractf128_ps(__m256(a), 1)))};
#elif defined(__SSE2__)
  return {Double(_mm_cvtps_pd(__m128(a))),
          Double(_mm_cvtps_pd(_mm_movehl_ps(__m128(a), __m128(a))))};
#else
  return {Double{a[0], a[1]}, Double{a[2], a[3]}};
#endif
}

}  // namespace ENGRAM_ISA
}  // namespace engram::simd
