#include "core/math/real_functions.h"

#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include "core/base/checksum.h"
#include "core/math/random.h"

namespace engram {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTiny = std::numeric_limits<double>::denorm_min();

// Numbers of both signs, evenly spread, and by magnitude from 2^-40 to 2^8.
std::vector<double> numbers() {
  std::vector<double> result;
  RandomStream stream(1, 2, 3);
  for (int i = 0; i < 100000; ++i) {
    result.push_back(stream.uniform(-1, 1));
    result.push_back(stream.uniform(-40, 40));
    const int exponent = stream.integer(-40, 8);
    result.push_back(std::ldexp(stream.uniform(-1, 1), exponent));
  }
  return result;
}

// How far a value is from the truth in units in the last place. long double has 11 bits more.
double units_off(double value, long double truth) {
  const double rounded = std::abs(static_cast<double>(truth));
  const double unit = std::nextafter(rounded, kInfinity) - rounded;
  return static_cast<double>(std::abs(static_cast<long double>(value) - truth) /
                             static_cast<long double>(unit));
}

template <class F, class Truth>
double max_units_off(const F& f, const Truth& truth, double lowest, double highest) {
  double most = 0;
  for (const double x : numbers()) {
    if (x < lowest || x > highest) continue;
    most = std::max(most, units_off(f(x), truth(static_cast<long double>(x))));
  }
  return most;
}

bool same(double a, double b) {
  return std::isnan(a) ? std::isnan(b)
                       : std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

TEST_CASE("Functions of real numbers are right to the last bits", "[base]") {
  const auto everywhere = kInfinity;
  CHECK(max_units_off(
            real::exp, [](long double x) { return std::exp(x); }, -700, 700) < 1);
  CHECK(max_units_off(
            real::log, [](long double x) { return std::log(x); }, kTiny, everywhere) < 1);
  CHECK(max_units_off(
            real::tanh, [](long double x) { return std::tanh(x); }, -everywhere, everywhere) < 3);
  CHECK(max_units_off(
            real::asin, [](long double x) { return std::asin(x); }, -1, 1) < 3);
  CHECK(max_units_off(
            real::tan, [](long double x) { return std::tan(x); }, -1.5, 1.5) < 3);
  double most = 0;
  const std::vector<double> all = numbers();
  for (std::size_t i = 1; i < all.size(); ++i) {
    most = std::max(most, units_off(real::atan2(all[i - 1], all[i]),
                                    std::atan2(static_cast<long double>(all[i - 1]),
                                               static_cast<long double>(all[i]))));
  }
  CHECK(most < 2);
}

TEST_CASE("Sine and cosine of angles however far", "[base]") {
  for (const double x : numbers()) {
    const auto exact = static_cast<long double>(x);
    REQUIRE(std::abs(static_cast<long double>(real::sin(x)) - std::sin(exact)) < 1.2e-16L);
    REQUIRE(std::abs(static_cast<long double>(real::cos(x)) - std::cos(exact)) < 1.2e-16L);
  }
  for (const double x : {1.00001e5, -1e9, 1e20, 1e38, 1e300}) {
    const double near = std::fmod(x, 6.283185307179586);
    CAPTURE(x);
    CHECK(same(real::sin(x), real::sin(near)));
    CHECK(same(real::cos(x), real::cos(near)));
    CHECK(std::abs(real::sin(x)) <= 1);
  }
  CHECK(std::isnan(real::sin(kInfinity)));
  CHECK(std::isnan(real::tan(std::nan(""))));
}

TEST_CASE("Functions of real numbers at the ends of their ranges", "[base]") {
  const double nan = std::nan("");
  const std::vector<double> special = {0.0,     -0.0,    1.0,       -1.0,      kTiny,
                                       -kTiny,  0.5,     kInfinity, nan,       1e-310,
                                       -1e-310, 1.7e308, -1.7e308,  -kInfinity};
  const auto near = [](double a, double b) {
    return same(a, b) || std::abs(a - b) <= 4e-16 * std::abs(b);
  };
  for (const double x : special) {
    CAPTURE(x);
    CHECK(near(real::exp(x), std::exp(x)));
    CHECK(near(real::log(x), std::log(x)));
    CHECK(near(real::tanh(x), std::tanh(x)));
    CHECK(near(real::asin(x), std::asin(x)));
    for (const double y : special) {
      CAPTURE(y);
      CHECK(near(real::atan2(y, x), std::atan2(y, x)));
    }
  }
  for (const double x : {-708.0, -709.5, -720.3, -744.9, -745.3, -800.0, 709.7, 709.79, 800.0}) {
    CAPTURE(x);
    const double truth = std::exp(x);
    // Below the smallest normal number, the last place is kTiny.
    CHECK((near(real::exp(x), truth) || std::abs(real::exp(x) - truth) <= kTiny));
  }
  for (const double x : {19.0, 19.99, 20.0, 21.0, -25.0, 1e9})
    CHECK(near(real::tanh(x), std::tanh(x)));
  CHECK(real::hypot(3, 4) == 5);
  CHECK(real::hypot(2, 3, 6) == 7);
}

// Equal on every machine: if this differs, so does what tasks compute.
TEST_CASE("Functions of real numbers have the bits of every other machine", "[base]") {
  std::vector<double> values;
  const std::vector<double> all = numbers();
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double x = all[i];
    for (const double value : {real::sin(x), real::cos(x), real::tan(x), real::exp(x),
                               real::log(std::abs(x)), real::tanh(x), real::atan2(all[i - 1], x)}) {
      values.push_back(value);
    }
    if (std::abs(x) <= 1) values.push_back(real::asin(x));
  }
  CHECK(checksum(std::as_bytes(std::span(values))) == 0x3e1b4ed5bf9ed867);
}

}  // namespace
}  // namespace engram
