#include "core/math/sine_cosine.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <vector>

namespace engram {
namespace {

std::vector<double> angles() {
  std::vector<double> result = {
      0.0, -0.0, 1e-300, 1e-9, 0.785398163397448, 1.5707963267948966, 3.141592653589793, 1e5, -1e5};
  for (int i = -20000; i <= 20000; ++i) {
    result.push_back(i * 3.3e-4);
    result.push_back(i * 0.7853981633974483);
    result.push_back(i * 4.999);
  }
  return result;
}

TEST_CASE("sine and cosine are right to the last bits", "[base]") {
  for (const double x : angles()) {
    double s = 0;
    double c = 0;
    sine_cosine(x, s, c);
    CAPTURE(x);
    // long double has 64 bits of mantissa.
    CHECK(std::abs(static_cast<long double>(s) - std::sin(static_cast<long double>(x))) < 1.2e-16L);
    CHECK(std::abs(static_cast<long double>(c) - std::cos(static_cast<long double>(x))) < 1.2e-16L);
  }
  double s = 1;
  double c = 0;
  sine_cosine(0.0, s, c);
  CHECK(s == 0);
  CHECK(c == 1);
  sine_cosine(std::nan(""), s, c);
  CHECK(std::isnan(s));
  CHECK(std::isnan(c));
}

TEST_CASE("sine and cosine of floats are right to a float's last bits", "[base]") {
  for (const double x : angles()) {
    if (std::abs(x) > 1e4) continue;
    const auto angle = static_cast<float>(x);
    float s = 0;
    float c = 0;
    sine_cosine(angle, s, c);
    CAPTURE(x);
    CHECK(std::abs(s - std::sin(static_cast<double>(angle))) < 8e-8);
    CHECK(std::abs(c - std::cos(static_cast<double>(angle))) < 8e-8);
  }
}

TEST_CASE("vectors of angles have the bits of single ones", "[base]") {
  int different = 0;
  for (const double x : angles()) {
    double s = 0;
    double c = 0;
    sine_cosine(x, s, c);
    simd::Double sines;
    simd::Double cosines;
    sine_cosine(simd::broadcast<simd::Double>(x), sines, cosines);
    const auto bits = [](double value) { return std::bit_cast<std::uint64_t>(value); };
    if (bits(sines[0]) != bits(s) || bits(cosines[1]) != bits(c)) ++different;

    const auto angle = static_cast<float>(x);
    float single_sine = 0;
    float single_cosine = 0;
    sine_cosine(angle, single_sine, single_cosine);
    simd::Float float_sines;
    simd::Float float_cosines;
    sine_cosine(simd::broadcast(angle), float_sines, float_cosines);
    const auto float_bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    if (float_bits(float_sines[3]) != float_bits(single_sine)) ++different;
    if (float_bits(float_cosines[3]) != float_bits(single_cosine)) ++different;
  }
  CHECK(different == 0);
}

}  // namespace
}  // namespace engram
