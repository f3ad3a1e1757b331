// Doubles side by side, one per environment, or a single one: what the kernels of the robot are
// written for.
//
// Kernels live in a namespace of their instruction set and call nothing of the standard library, so
// that the linker cannot merge code compiled for a wide instruction set into code that runs
// everywhere. All operations are exactly rounded ones, so a lane's bits are those of a single
// double.
#pragma once

#include "core/base/intrinsics.h"

#define ENGRAM_LANES_INLINE [[maybe_unused]] inline __attribute__((always_inline))

#if defined(__AVX512F__)
#define ENGRAM_LANES lanes_avx512
#elif defined(__AVX2__)
#define ENGRAM_LANES lanes_avx2
#else
#define ENGRAM_LANES lanes_plain
#endif

namespace engram {
inline namespace ENGRAM_LANES {

template <int kWidth>
struct LaneVector {
  typedef double Type __attribute__((vector_size(8 * kWidth)));  // NOLINT(modernize-use-using)
};
template <>
struct LaneVector<1> {
  using Type = double;
};

template <class V>
constexpr int kLanesOf = sizeof(V) / sizeof(double);

template <class V>
ENGRAM_LANES_INLINE V spread(double value) {
  return value - V{};
}

// Rows of lanes lie one after the other, aligned to whole vectors.
template <class V>
ENGRAM_LANES_INLINE V row(const double* rows, int index) {
  V value;
  __builtin_memcpy(&value, rows + index * kLanesOf<V>, sizeof value);
  return value;
}
template <class V>
ENGRAM_LANES_INLINE void set_row(double* rows, int index, V value) {
  __builtin_memcpy(rows + index * kLanesOf<V>, &value, sizeof value);
}

ENGRAM_LANES_INLINE double root(double a) { return __builtin_sqrt(a); }
// The first if it is less (greater) than the second; so the second if one is NaN.
ENGRAM_LANES_INLINE double lesser(double a, double b) { return a < b ? a : b; }
ENGRAM_LANES_INLINE double greater(double a, double b) { return a > b ? a : b; }
ENGRAM_LANES_INLINE bool any(bool mask) { return mask; }
ENGRAM_LANES_INLINE unsigned bits_of(bool mask) { return mask ? 1U : 0U; }

using Lanes2 = LaneVector<2>::Type;
using Mask2 = decltype(Lanes2{} < Lanes2{});
#if defined(__SSE2__)
ENGRAM_LANES_INLINE Lanes2 root(Lanes2 a) { return _mm_sqrt_pd(a); }
ENGRAM_LANES_INLINE Lanes2 lesser(Lanes2 a, Lanes2 b) { return _mm_min_pd(a, b); }
ENGRAM_LANES_INLINE Lanes2 greater(Lanes2 a, Lanes2 b) { return _mm_max_pd(a, b); }
ENGRAM_LANES_INLINE unsigned bits_of(Mask2 mask) {
  return static_cast<unsigned>(_mm_movemask_pd(__builtin_bit_cast(__m128d, mask)));
}
#else
ENGRAM_LANES_INLINE Lanes2 root(Lanes2 a) { return Lanes2{root(a[0]), root(a[1])}; }
ENGRAM_LANES_INLINE Lanes2 lesser(Lanes2 a, Lanes2 b) { return a < b ? a : b; }
ENGRAM_LANES_INLINE Lanes2 greater(Lanes2 a, Lanes2 b) { return a > b ? a : b; }
ENGRAM_LANES_INLINE unsigned bits_of(Mask2 mask) {
  return bits_of(mask[0] != 0) | bits_of(mask[1] != 0) << 1U;
}
#endif
ENGRAM_LANES_INLINE bool any(Mask2 mask) { return bits_of(mask) != 0; }

#if defined(__AVX2__)
using Lanes4 = LaneVector<4>::Type;
ENGRAM_LANES_INLINE Lanes4 root(Lanes4 a) { return _mm256_sqrt_pd(a); }
ENGRAM_LANES_INLINE Lanes4 lesser(Lanes4 a, Lanes4 b) { return _mm256_min_pd(a, b); }
ENGRAM_LANES_INLINE Lanes4 greater(Lanes4 a, Lanes4 b) { return _mm256_max_pd(a, b); }
using Mask4 = decltype(Lanes4{} < Lanes4{});
ENGRAM_LANES_INLINE unsigned bits_of(Mask4 mask) {
  return static_cast<unsigned>(_mm256_movemask_pd(__builtin_bit_cast(__m256d, mask)));
}
ENGRAM_LANES_INLINE bool any(Mask4 mask) { return bits_of(mask) != 0; }
#endif

#if defined(__AVX512F__)
using Lanes8 = LaneVector<8>::Type;
ENGRAM_LANES_INLINE Lanes8 root(Lanes8 a) { return _mm512_sqrt_pd(a); }
ENGRAM_LANES_INLINE Lanes8 lesser(Lanes8 a, Lanes8 b) { return _mm512_min_pd(a, b); }
ENGRAM_LANES_INLINE Lanes8 greater(Lanes8 a, Lanes8 b) { return _mm512_max_pd(a, b); }
using Mask8 = decltype(Lanes8{} < Lanes8{});
ENGRAM_LANES_INLINE unsigned bits_of(Mask8 mask) {
  return _mm512_movepi64_mask(__builtin_bit_cast(__m512i, mask));
}
ENGRAM_LANES_INLINE bool any(Mask8 mask) { return bits_of(mask) != 0; }
#endif

// Of masks: bools, or vectors of them.
ENGRAM_LANES_INLINE bool either(bool a, bool b) { return a || b; }
ENGRAM_LANES_INLINE bool both(bool a, bool b) { return a && b; }
template <class Mask>
ENGRAM_LANES_INLINE Mask either(Mask a, Mask b) {
  return a | b;
}
template <class Mask>
ENGRAM_LANES_INLINE Mask both(Mask a, Mask b) {
  return a & b;
}

template <class V>
ENGRAM_LANES_INLINE V magnitude(V a) {
  return greater(a, -a);
}

}  // namespace ENGRAM_LANES
}  // namespace engram
