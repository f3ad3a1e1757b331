// Vectors of the instruction set that tests are compiled for; kernels of all sets are compared in
// tests/core/robot/lane_kernel_test.cc and tests/render/cpu/pixels_test.cc.
#include "core/math/simd.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

namespace engram {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// first, first + step, and so on, one number in each lane.
simd::Double numbers(double first, double step) {
  simd::Double result;
  for (int i = 0; i < simd::kDoubles; ++i) result[i] = first + step * i;
  return result;
}

TEST_CASE("A lane has the result of a single double", "[math]") {
  const simd::Double a = numbers(0.3, 1.7);
  const simd::Double b = numbers(2.1, -0.9);
  const simd::Double least = simd::min(a, b);
  const simd::Double most = simd::max(a, b);
  const simd::Double root = simd::sqrt(a);
  const simd::Double absolute = simd::abs(b - a);
  const simd::Double clamped = simd::clamp(a, 0.5, 1.5);
  for (int i = 0; i < simd::kDoubles; ++i) {
    CHECK(least[i] == simd::min(a[i], b[i]));
    CHECK(most[i] == simd::max(a[i], b[i]));
    CHECK(root[i] == std::sqrt(a[i]));
    CHECK(absolute[i] == std::abs(b[i] - a[i]));
    CHECK(clamped[i] == simd::clamp(a[i], 0.5, 1.5));
  }
}

TEST_CASE("A lane of floats has the result of a single float", "[math]") {
  simd::Float a;
  simd::Float b;
  for (int i = 0; i < simd::kFloats; ++i) {
    a[i] = 0.3F + 1.7F * static_cast<float>(i);
    b[i] = 2.1F - 0.9F * static_cast<float>(i);
  }
  const simd::Float least = simd::min(a, b);
  const simd::Float root = simd::sqrt(a);
  const simd::Float clamped = simd::clamp(a, 0.5F, 1.5F);
  const simd::FloatMask less = a < b;
  for (int i = 0; i < simd::kFloats; ++i) {
    CHECK(least[i] == simd::min(a[i], b[i]));
    CHECK(root[i] == std::sqrt(a[i]));
    CHECK(clamped[i] == simd::clamp(a[i], 0.5F, 1.5F));
    CHECK((simd::bits(less) >> static_cast<unsigned>(i) & 1U) == (a[i] < b[i] ? 1U : 0U));
  }
}

TEST_CASE("Lanes keep their places between floats and doubles", "[math]") {
  simd::Float a;
  for (int i = 0; i < simd::kFloats; ++i) a[i] = static_cast<float>(i);
  const simd::DoublePair wide = 0.1 * (simd::to_doubles(a) + 1.0);
  const simd::Float rounded = simd::to_floats(wide);
  for (int i = 0; i < simd::kFloats; ++i) {
    const simd::Double half = i < simd::kDoubles ? wide.low : wide.high;
    CHECK(half[i % simd::kDoubles] == 0.1 * (i + 1.0));
    CHECK(rounded[i] == static_cast<float>(0.1 * (i + 1.0)));
  }
}

TEST_CASE("min and max give the second number if one is NaN", "[math]") {
  CHECK(simd::min(kNan, 1.0) == 1);
  CHECK(std::isnan(simd::min(1.0, kNan)));
  CHECK(simd::max(simd::broadcast<simd::Double>(kNan), simd::broadcast<simd::Double>(2))[0] == 2);
}

TEST_CASE("Masks of doubles have a bit for each lane", "[math]") {
  const simd::Double a = numbers(0, 1);
  const simd::DoubleMask first = a < 0.5;
  CHECK(simd::bits(first) == 1U);
  CHECK(simd::any(first));
  CHECK_FALSE(simd::any(a < 0.0));
  CHECK(simd::bits(simd::logical_or(first, a >= 0.5)) == (1U << simd::kDoubles) - 1);
  CHECK(simd::bits(simd::logical_and(first, a >= 0.5)) == 0U);
}

TEST_CASE("Doubles are rounded down, up and towards zero", "[math]") {
  for (const double value : {-2.5, -2.0, -0.2, 0.0, 0.7, 3.0}) {
    const auto all = simd::broadcast<simd::Double>(value);
    CHECK(simd::floor(all)[0] == std::floor(value));
    CHECK(simd::ceil(all)[0] == std::ceil(value));
    CHECK(simd::truncate(all)[0] == std::trunc(value));
  }
}

TEST_CASE("Floats are compared and selected lane by lane", "[math]") {
  simd::Float a;
  for (int i = 0; i < simd::kFloats; ++i) a[i] = static_cast<float>(i);
  const simd::Mask small = simd::less(a, simd::broadcast(1.5F));
  CHECK(simd::bits(small) == 3);
  const simd::Float chosen = simd::select(small, simd::broadcast(-1.0F), a);
  CHECK(chosen[0] == -1);
  CHECK(chosen[2] == 2);
  CHECK(simd::all(simd::at_most(simd::broadcast(0.0F), a)));
  CHECK(simd::round(simd::broadcast(2.5F))[0] == 2);  // to even
  CHECK(simd::abs(simd::broadcast(-3.0F))[1] == 3);
  for (const float zero : {0.0F, -0.0F}) {
    CHECK_FALSE(std::signbit(simd::abs(zero)));
    CHECK_FALSE(std::signbit(simd::abs(simd::broadcast(zero))[0]));
  }
}

}  // namespace
}  // namespace engram
