// Sine and cosine with the same bits on every processor; those of the C library differ between
// processors with and without fused multiplication.
#pragma once

#include "core/math/simd.h"

namespace engram {
inline namespace ENGRAM_ISA {

// Polynomials of least error for |reduced| <= pi / 4; `low` is what the reduction lost.
template <class V>
ENGRAM_INLINE void reduced_sine_cosine(V reduced, V low, V& sine, V& cosine) {
  const V z = reduced * reduced;
  if constexpr (sizeof(simd::ScalarOf<V>) == sizeof(float)) {
    constexpr float kSine[3] = {-1.6666654611e-1F, 8.3321608736e-3F, -1.9515295891e-4F};
    constexpr float kCosine[3] = {4.166664568298827e-2F, -1.388731625493765e-3F,
                                  2.443315711809948e-5F};
    const V one_less = 1.0F - 0.5F * z;
    const V p = kSine[0] + z * (kSine[1] + z * kSine[2]);
    const V c = kCosine[0] + z * (kCosine[1] + z * kCosine[2]);
    sine = reduced + (low * one_less + reduced * (z * p));
    cosine = one_less + (z * (z * c) - reduced * low);
  } else {
    constexpr double kSine[6] = {-0x1.5555555555555p-3,  0x1.1111111110bb3p-7,
                                 -0x1.a01a019e83b98p-13, 0x1.71de379693ea6p-19,
                                 -0x1.ae600b05993c1p-26, 0x1.5e0b18e278ed2p-33};
    constexpr double kCosine[6] = {0.0416666666666666654,   -0.00138888888888873975,
                                   0.000024801587298765915, -2.75573172717597423e-7,
                                   2.08761462604096352e-9,  -1.13826310291810988e-11};
    const V p =
        kSine[0] + z * (kSine[1] + z * (kSine[2] + z * (kSine[3] + z * (kSine[4] + z * kSine[5]))));
    const V c =
        kCosine[0] +
        z * (kCosine[1] + z * (kCosine[2] + z * (kCosine[3] + z * (kCosine[4] + z * kCosine[5]))));
    const V half = 0.5 * z;
    const V one_less = 1.0 - half;
    sine = reduced + (low * one_less + reduced * (z * p));
    cosine = one_less + (((1.0 - one_less) - half) + (z * (z * c) - reduced * low));
  }
}

// x in rad. V: double, or a vector of doubles: |x| <= 1e5, within 1.2e-16 of the truth; float, or a
// vector of floats: |x| <= 1e4, within 8e-8. Vectors give lane by lane what single numbers do.
// Needs rounding to nearest.
template <class V>
ENGRAM_INLINE void sine_cosine(V x, V& sine, V& cosine) {
  using Scalar = simd::ScalarOf<V>;
  constexpr bool kIsFloat = sizeof(Scalar) == sizeof(float);
  // Adding this rounds to an integer, which then stands in the lowest bits.
  constexpr auto kRound = static_cast<Scalar>(kIsFloat ? 0x1.8p23 : 0x1.8p52);
  constexpr auto kTwoByPi = static_cast<Scalar>(0x1.45f306dc9c883p-1);
  // pi / 2 in three parts; integers below 2^14 (floats), 2^20 (doubles) times the first two are
  // exact.
  constexpr Scalar kHalfPi[3] = {
      static_cast<Scalar>(kIsFloat ? 0x1.92p+0 : 0x1.921fb544p+0),
      static_cast<Scalar>(kIsFloat ? 0x1.fbp-12 : 0x1.0b4611a6p-34),
      static_cast<Scalar>(kIsFloat ? 0x1.5110b4611a626p-22 : 0x1.3198a2e037073p-69)};
  const V shifted = x * kTwoByPi + kRound;
  const V turns = shifted - kRound;
  const V high = x - turns * kHalfPi[0];
  const V mid = turns * kHalfPi[1];
  V reduced = high - mid;
  // The part that the last two subtractions lose.
  V low = ((high - reduced) - mid) - turns * kHalfPi[2];
  if constexpr (kIsFloat) {  // more than a last bit
    const V sum = reduced + low;
    low = (reduced - sum) + low;
    reduced = sum;
  }
  V s;
  V c;
  reduced_sine_cosine(reduced, low, s, c);

  // Quarter turns swap the two, half turns change signs.
  using Bits = decltype(V{} < V{});  // integers of the same size; bool for a single number
  if constexpr (std::is_same_v<Bits, bool>) {
    using Word = std::conditional_t<kIsFloat, std::uint32_t, std::uint64_t>;
    const auto quadrant = __builtin_bit_cast(Word, shifted);
    const bool swaps = (quadrant & 1) != 0;
    sine = swaps ? c : s;
    cosine = swaps ? s : c;
    if ((quadrant & 2) != 0) sine = -sine;
    if (((quadrant + 1) & 2) != 0) cosine = -cosine;
  } else {
    constexpr int kToSign = 8 * sizeof(Scalar) - 2;
    const auto quadrant = __builtin_bit_cast(Bits, shifted);
    const Bits swaps = -(quadrant & 1);
    const auto s_bits = __builtin_bit_cast(Bits, s);
    const auto c_bits = __builtin_bit_cast(Bits, c);
    sine =
        __builtin_bit_cast(V, ((s_bits & ~swaps) | (c_bits & swaps)) ^ ((quadrant & 2) << kToSign));
    cosine = __builtin_bit_cast(
        V, ((c_bits & ~swaps) | (s_bits & swaps)) ^ (((quadrant + 1) & 2) << kToSign));
  }
}

}  // namespace ENGRAM_ISA
}  // namespace engram
