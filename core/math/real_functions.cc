#include "core/math/real_functions.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

#include "core/math/sine_cosine.h"

namespace engram::real {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Logarithm of 2 in two parts; integers below 2^20 times the first are exact.
constexpr double kLn2High = 0x1.62e42ffp-1;
constexpr double kLn2Low = -0x1.718432a1b0e26p-35;

// c[0] + c[1] x + ...
template <std::size_t N>
double polynomial(const double (&c)[N], double x) {
  double sum = c[N - 1];
  for (std::size_t i = N - 1; i > 0; --i) sum = c[i - 1] + x * sum;
  return sum;
}

// 2^k, -1022 <= k <= 1023.
double power_of_two(int k) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + k) << 52);
}

// e^x = 2^k (1 + rest), |rest| < 0.42; for |x| < 1000.
struct Exponential {
  int k;
  double rest;
};

Exponential exponential(double x) {
  constexpr double kRound = 0x1.8p52;  // adding this rounds to an integer
  constexpr double kPerLn2 = 0x1.71547652b82fep+0;
  // Coefficients of least error for (e^r - 1 - r) / r^2, |r| <= ln(2) / 2.
  constexpr double kTail[] = {0x1p-1,
                              0x1.5555555555557p-3,
                              0x1.5555555555558p-5,
                              0x1.11111111100dbp-7,
                              0x1.6c16c16c151fdp-10,
                              0x1.a01a01abe81f8p-13,
                              0x1.a01a01acfac26p-16,
                              0x1.71de02313958cp-19,
                              0x1.27e4cccde21d8p-22,
                              0x1.af4dea28693e2p-26,
                              0x1.1f8b4cb12c542p-29};
  const double shifted = x * kPerLn2 + kRound;
  const double k = shifted - kRound;
  const double r = (x - k * kLn2High) - k * kLn2Low;
  return {static_cast<std::int32_t>(std::bit_cast<std::uint64_t>(shifted)),
          r + r * r * polynomial(kTail, r)};
}

void sine_cosine_of_any(double x, double& sine, double& cosine) {
  constexpr double kFar = 1e5;
  sine_cosine(std::abs(x) > kFar ? std::fmod(x, 2 * std::numbers::pi) : x, sine, cosine);
}

}  // namespace

double sin(double x) {
  double sine = 0;
  double cosine = 0;
  sine_cosine_of_any(x, sine, cosine);
  return sine;
}

double cos(double x) {
  double sine = 0;
  double cosine = 0;
  sine_cosine_of_any(x, sine, cosine);
  return cosine;
}

double tan(double x) {
  double sine = 0;
  double cosine = 0;
  sine_cosine_of_any(x, sine, cosine);
  return sine / cosine;
}

double asin(double x) { return atan2(x, std::sqrt((1 - x) * (1 + x))); }

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNan;
  // Coefficients of least error for (atan(t) / t - 1) / t^2, |t| <= tan(pi / 8).
  constexpr double kTail[] = {-0x1.5555555555555p-2, 0x1.9999999999957p-3,  -0x1.249249248db9ap-3,
                              0x1.c71c71c32e4dbp-4,  -0x1.745d166580569p-4, 0x1.3b1393a688cd3p-4,
                              -0x1.110e958d54eeep-4, 0x1.e19b39183ee23p-5,  -0x1.ac8291b8c2274p-5,
                              0x1.750072a3d6494p-5,  -0x1.1b8877ac5522bp-5, 0x1.0b86966805c52p-6};
  constexpr double kTangentOfEighth = 0x1.a827999fcef32p-2;
  // Multiples of pi / 4, and what the doubles leave out.
  constexpr double kAngle[5] = {0, 0x1.921fb54442d18p-1, 0x1.921fb54442d18p+0, 0x1.2d97c7f3321d2p+1,
                                0x1.921fb54442d18p+1};
  constexpr double kLeftOut[5] = {0, 0x1.1a62633145c07p-55, 0x1.1a62633145c07p-54,
                                  0x1.a79394c9e8a0ap-54, 0x1.1a62633145c07p-53};
  const bool steep = std::abs(y) > std::abs(x);
  double small = std::abs(steep ? x : y);
  double large = std::abs(steep ? y : x);
  if (large == kInfinity) {
    small = small == kInfinity ? 1 : 0;
    large = 1;
  } else if (large > 0x1p1000) {  // the sum below must not overflow
    small *= 0x1p-10;
    large *= 0x1p-10;
  } else if (large == 0) {
    large = 1;
  }

  // The angle is `eighths` * pi / 4, plus or minus atan(t).
  const bool upper = small > kTangentOfEighth * large;
  const double t = upper ? (small - large) / (small + large) : small / large;
  std::size_t eighths = upper ? 1 : 0;
  double rest = t + t * (t * t * polynomial(kTail, t * t));
  if (steep) {
    eighths = 2 - eighths;
    rest = -rest;
  }
  if (std::signbit(x)) {
    eighths = 4 - eighths;
    rest = -rest;
  }
  return std::copysign(kAngle[eighths] + (rest + kLeftOut[eighths]), y);
}

double exp(double x) {
  if (std::isnan(x)) return x;
  if (x > 709.8) return kInfinity;
  if (x < -745.2) return 0;
  const Exponential e = exponential(x);
  // In two steps, since 2^k alone may be out of range.
  const int half = e.k / 2;
  return (1 + e.rest) * power_of_two(half) * power_of_two(e.k - half);
}

double log(double x) {
  if (std::isnan(x) || x == kInfinity) return x;
  if (x <= 0) return x == 0 ? -kInfinity : kNan;
  // Coefficients of least error for (2 atanh(s) / s - 2) / s^2, |s| <= (sqrt(2) - 1) / (sqrt(2) +
  // 1).
  constexpr double kTail[] = {0x1.5555555555558p-1, 0x1.9999999995223p-2, 0x1.2492492e03e4ep-2,
                              0x1.c71c62d03d20fp-3, 0x1.7462ba281c955p-3, 0x1.39fdb948e338cp-3,
                              0x1.2b5fbe9e436b8p-3};
  int k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    k = -54;
  }
  // x = 2^k (1 + f), with 1 + f between the root of 1/2 and that of 2.
  auto bits = std::bit_cast<std::uint64_t>(x);
  k += static_cast<int>(bits >> 52) - 1023;
  bits = (bits & 0x000fffffffffffff) | 0x3ff0000000000000;
  double mantissa = std::bit_cast<double>(bits);
  if (mantissa > std::numbers::sqrt2) {
    mantissa *= 0.5;
    ++k;
  }
  const double f = mantissa - 1;
  // log(1 + f) = 2 atanh(s), where 2 s = f - s f.
  const double s = f / (2 + f);
  const double z = s * s;
  const double less = s * (f - z * polynomial(kTail, z));
  return k * kLn2High + (f - (less - k * kLn2Low));
}

double tanh(double x) {
  if (std::isnan(x)) return x;
  constexpr double kOneFrom = 20;  // from here on the nearest double is 1
  double result = 1;
  if (std::abs(x) < kOneFrom) {
    // (e^2x - 1) / (e^2x + 1)
    const Exponential e = exponential(2 * std::abs(x));
    const double scale = power_of_two(e.k);
    const double power_less_1 = scale * e.rest + (scale - 1);
    result = power_less_1 / (power_less_1 + 2);
  }
  return std::copysign(result, x);
}

}  // namespace engram::real
