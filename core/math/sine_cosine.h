// Sine and cosine with the same bits on every processor; those of the C library differ between
// processors with and without fused multiplication.
#pragma once

#include <bit>
#include <cstdint>
#include <type_traits>

namespace engram {

// x in rad, |x| <= 1e5: within 1.2e-16 of the truth. V: double, or a vector of doubles of the
// compiler's (then lane by lane what double gives). Needs rounding to nearest.
template <class V>
inline void sine_cosine(V x, V& sine, V& cosine) {
  // Adding this rounds to an integer, which then stands in the lowest bits.
  constexpr double kRound = 0x1.8p52;
  constexpr double kTwoByPi = 0x1.45f306dc9c883p-1;
  // pi / 2 in three parts; integers below 2^20 times the first two are exact.
  constexpr double kHalfPi[3] = {0x1.921fb544p+0, 0x1.0b4611a6p-34, 0x1.3198a2e037073p-69};
  // Coefficients of least error for |x| <= pi / 4.
  constexpr double kSine[6] = {-0x1.5555555555555p-3,  0x1.1111111110bb3p-7,
                               -0x1.a01a019e83b98p-13, 0x1.71de379693ea6p-19,
                               -0x1.ae600b05993c1p-26, 0x1.5e0b18e278ed2p-33};
  constexpr double kCosine[6] = {0.0416666666666666654,   -0.00138888888888873975,
                                 0.000024801587298765915, -2.75573172717597423e-7,
                                 2.08761462604096352e-9,  -1.13826310291810988e-11};
  const V shifted = x * kTwoByPi + kRound;
  const V turns = shifted - kRound;
  const V high = x - turns * kHalfPi[0];
  const V mid = turns * kHalfPi[1];
  const V reduced = high - mid;
  // The part that the last two subtractions lose.
  const V low = ((high - reduced) - mid) - turns * kHalfPi[2];
  const V z = reduced * reduced;
  const V p =
      kSine[0] + z * (kSine[1] + z * (kSine[2] + z * (kSine[3] + z * (kSine[4] + z * kSine[5]))));
  const V c =
      kCosine[0] +
      z * (kCosine[1] + z * (kCosine[2] + z * (kCosine[3] + z * (kCosine[4] + z * kCosine[5]))));
  const V half = 0.5 * z;
  const V one_less = 1.0 - half;
  const V s = reduced + (low * one_less + reduced * (z * p));
  const V k = one_less + (((1.0 - one_less) - half) + (z * (z * c) - reduced * low));

  // Quarter turns swap the two, half turns change signs.
  if constexpr (std::is_same_v<V, double>) {
    const auto quadrant = std::bit_cast<std::uint64_t>(shifted);
    const bool swaps = (quadrant & 1) != 0;
    sine = swaps ? k : s;
    cosine = swaps ? s : k;
    if ((quadrant & 2) != 0) sine = -sine;
    if (((quadrant + 1) & 2) != 0) cosine = -cosine;
  } else {
    using Bits = decltype(V{} < V{});  // integers of the same size
    const auto quadrant = std::bit_cast<Bits>(shifted);
    const Bits swaps = -(quadrant & 1);
    const auto s_bits = std::bit_cast<Bits>(s);
    const auto k_bits = std::bit_cast<Bits>(k);
    sine = std::bit_cast<V>(((s_bits & ~swaps) | (k_bits & swaps)) ^ ((quadrant & 2) << 62));
    cosine =
        std::bit_cast<V>(((k_bits & ~swaps) | (s_bits & swaps)) ^ (((quadrant + 1) & 2) << 62));
  }
}

}  // namespace engram
