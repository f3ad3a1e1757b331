#include "core/math/random.h"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "core/base/error.h"

namespace engram {
namespace {

using Words = std::array<std::uint32_t, 4>;

Words next_words(RandomStream& stream) {
  Words words;
  for (std::uint32_t& word : words) word = stream.next_u32();
  return words;
}

// Pearson's statistic of counts that should all be equal.
double chi_square(const std::vector<int>& counts) {
  double total = 0;
  for (const int count : counts) total += count;
  const double expected = total / static_cast<double>(counts.size());
  double sum = 0;
  for (const int count : counts) sum += (count - expected) * (count - expected) / expected;
  return sum;
}

// What Pearson's statistic exceeds once in about 30,000 times (Wilson and Hilferty, four sigmas).
double chi_square_limit(std::size_t bins) {
  const double freedom = static_cast<double>(bins) - 1;
  const double spread = 2 / (9 * freedom);
  return freedom * std::pow(1 - spread + 4 * std::sqrt(spread), 3);
}

// Kolmogorov and Smirnov's distance between samples and a distribution, times sqrt(n); beyond 2.3
// once in about 20,000 times.
double ks_statistic(std::vector<double> samples, const std::function<double(double)>& cdf) {
  std::ranges::sort(samples);
  const auto count = static_cast<double>(samples.size());
  double distance = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const double p = cdf(samples[i]);
    const auto below = static_cast<double>(i);
    distance = std::max({distance, p - below / count, (below + 1) / count - p});
  }
  return distance * std::sqrt(count);
}
constexpr double kKsLimit = 2.3;

TEST_CASE("RandomStream draws Philox4x32-10's published vectors", "[random]") {
  // From kat_vectors of Random123: counter and key all zeros, and the digits of pi. Their first
  // counter word is the block index, which a stream reaches by drawing; zero is at once.
  RandomStream zeros(0, 0, 0);
  CHECK(next_words(zeros) == Words{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
}

TEST_CASE("RandomStream matches Philox written out, in every part of key and counter", "[random]") {
  // The ten rounds as Salmon and others define them.
  const auto philox = [](Words counter, std::array<std::uint32_t, 2> key) {
    for (int round = 0; round < 10; ++round) {
      const std::uint64_t a = std::uint64_t{0xD2511F53} * counter[0];
      const std::uint64_t b = std::uint64_t{0xCD9E8D57} * counter[2];
      counter = {
          static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
          static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
      key[0] += 0x9E3779B9;
      key[1] += 0xBB67AE85;
    }
    return counter;
  };
  // The reference itself, against the other two published vectors.
  constexpr std::uint32_t kOnes = 0xffffffff;
  REQUIRE(philox({kOnes, kOnes, kOnes, kOnes}, {kOnes, kOnes}) ==
          Words{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
  REQUIRE(philox({0x243f6a88, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}) ==
          Words{0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});

  RandomStream stream(0x299f31d0a4093822, 0x0370734413198a2e, 0x85a308d3);
  for (std::uint32_t block = 0; block < 5; ++block) {
    CHECK(next_words(stream) ==
          philox({block, 0x85a308d3, 0x13198a2e, 0x03707344}, {0xa4093822, 0x299f31d0}));
  }
}

TEST_CASE("RandomStream joins words to 64 bits, low word first", "[random]") {
  RandomStream words(7, 8, 9);
  RandomStream pairs = words;
  for (int i = 0; i < 10; ++i) {
    const std::uint64_t low = words.next_u32();
    const std::uint64_t high = words.next_u32();
    CHECK(pairs.next_u64() == (high << 32 | low));
  }
}

TEST_CASE("A copied RandomStream continues alike", "[random]") {
  RandomStream original(1, 2, 3);
  for (int drawn = 0; drawn < 9; ++drawn) {
    RandomStream copy(0, 0, 0);
    std::memcpy(static_cast<void*>(&copy), &original, sizeof(copy));
    RandomStream reference = original;
    for (int i = 0; i < 20; ++i) REQUIRE(copy.next_u32() == reference.next_u32());
    original.next_u32();
  }
}

TEST_CASE("RandomStreams of other seeds, episodes and purposes are unrelated", "[random]") {
  // No block occurs twice among neighbours in every direction.
  std::set<Words> blocks;
  int drawn = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    for (std::uint64_t episode = 0; episode < 10; ++episode) {
      for (std::uint32_t purpose = 0; purpose < 10; ++purpose) {
        RandomStream stream(seed, episode, purpose);
        for (int i = 0; i < 3; ++i, ++drawn) blocks.insert(next_words(stream));
      }
    }
  }
  CHECK(blocks.size() == static_cast<std::size_t>(drawn));

  // Neighbouring streams give uncorrelated values: sums of products are within 4.5 sigmas.
  const auto correlation = [](auto&& make_a, auto&& make_b) {
    constexpr int kPairs = 20000;
    double sum = 0;
    for (std::uint32_t i = 0; i < kPairs; ++i) {
      RandomStream a = make_a(i);
      RandomStream b = make_b(i);
      sum += (a.uniform() - 0.5) * (b.uniform() - 0.5);
    }
    return sum / kPairs * 12 * std::sqrt(double{kPairs});
  };
  const auto base = [](std::uint32_t i) { return RandomStream(i, 5, 6); };
  CHECK(std::abs(correlation(base, [](auto i) { return RandomStream(i + 1, 5, 6); })) < 4.5);
  CHECK(std::abs(correlation(base, [](auto i) { return RandomStream(i, 6, 6); })) < 4.5);
  CHECK(std::abs(correlation(base, [](auto i) { return RandomStream(i, 5, 7); })) < 4.5);
}

TEST_CASE("Pinning one purpose leaves the others alone", "[random]") {
  RandomStream untouched(11, 3, 2);
  const Words expected = next_words(untouched);
  RandomStream pinned(11, 3, 1);
  for (int i = 0; i < 1000; ++i) pinned.normal();
  RandomStream other(11, 3, 2);
  CHECK(next_words(other) == expected);
}

TEST_CASE("uniform() is uniform from 0 to below 1", "[random]") {
  RandomStream stream(1, 0, 0);
  std::vector<double> samples(100000);
  for (double& x : samples) x = stream.uniform();
  CHECK(*std::ranges::min_element(samples) >= 0);
  CHECK(*std::ranges::max_element(samples) < 1);
  CHECK(std::ranges::all_of(
      samples, [](double x) { return std::ldexp(x, 53) == std::floor(std::ldexp(x, 53)); }));
  CHECK(ks_statistic(samples, [](double x) { return x; }) < kKsLimit);
}

TEST_CASE("uniform(lo, hi) stays in its range", "[random]") {
  RandomStream stream(2, 0, 0);
  std::vector<double> samples(50000);
  for (double& x : samples) x = stream.uniform(-3, 5);
  CHECK(ks_statistic(samples, [](double x) { return (x + 3) / 8; }) < kKsLimit);

  CHECK(stream.uniform(4, 4) == 4);

  // Where rounding would reach the upper bound.
  const double next = std::nextafter(1.0, 2.0);
  for (int i = 0; i < 1000; ++i) REQUIRE(stream.uniform(1, next) == 1);
}

TEST_CASE("RandomStream refuses empty and infinite ranges and draws nothing", "[random]") {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kMax = std::numeric_limits<double>::max();
  RandomStream stream(2, 0, 0);
  RandomStream reference = stream;
  CHECK_THROWS_AS(stream.uniform(1, 0), Error);
  CHECK_THROWS_AS(stream.uniform(0, kInf), Error);
  CHECK_THROWS_AS(stream.uniform(0, std::nan("")), Error);
  CHECK_THROWS_AS(stream.uniform(-kMax, kMax), Error);
  CHECK_THROWS_AS(stream.integer(1, 0), Error);
  CHECK(stream.next_u32() == reference.next_u32());
}

TEST_CASE("integer() covers its range evenly", "[random]") {
  RandomStream stream(3, 0, 0);
  const int count = GENERATE(1, 2, 3, 5, 7, 9, 16, 100);
  std::vector<int> counts(static_cast<std::size_t>(count));
  for (int i = 0; i < 20000; ++i) {
    const int x = stream.integer(-4, -4 + count - 1);
    REQUIRE((x >= -4 && x < -4 + count));
    ++counts[static_cast<std::size_t>(x + 4)];
  }
  if (count > 1) CHECK(chi_square(counts) < chi_square_limit(counts.size()));
}

TEST_CASE("integer() is unbiased where the range does not divide 2^32", "[random]") {
  // 3 * 2^30 values. A remainder would hit the lowest third of them twice as often, a product
  // without rejection every third one.
  constexpr int kThird = 1 << 30;
  constexpr int kLow = std::numeric_limits<int>::min();
  RandomStream stream(4, 0, 0);
  std::vector<int> thirds(3);
  std::vector<int> residues(3);
  for (int i = 0; i < 30000; ++i) {
    const std::int64_t offset = std::int64_t{stream.integer(kLow, kThird - 1)} - kLow;
    ++thirds[static_cast<std::size_t>(offset / kThird)];
    ++residues[static_cast<std::size_t>(offset % 3)];
  }
  CHECK(chi_square(thirds) < chi_square_limit(3));
  CHECK(chi_square(residues) < chi_square_limit(3));
}

TEST_CASE("integer() takes the full range of int", "[random]") {
  RandomStream stream(5, 0, 0);
  RandomStream words = stream;
  for (int i = 0; i < 100; ++i) {
    const auto expected =
        static_cast<int>(std::int64_t{words.next_u32()} - (std::int64_t{1} << 31));
    REQUIRE(stream.integer(std::numeric_limits<int>::min(), std::numeric_limits<int>::max()) ==
            expected);
  }
}

TEST_CASE("normal() is standard normal", "[random]") {
  RandomStream stream(6, 0, 0);
  constexpr int kCount = 100000;
  std::vector<double> samples(kCount);
  double mean = 0;
  double variance = 0;
  double successive = 0;
  for (std::size_t i = 0; i < kCount; ++i) {
    samples[i] = stream.normal();
    REQUIRE(std::isfinite(samples[i]));
    mean += samples[i] / kCount;
    variance += samples[i] * samples[i] / kCount;
    if (i > 0) successive += samples[i] * samples[i - 1] / kCount;
  }
  CHECK(ks_statistic(samples, [](double x) { return std::erfc(-x / std::sqrt(2)) / 2; }) <
        kKsLimit);
  CHECK(std::abs(mean) < 0.014);          // 4.5 sigmas of 1 / sqrt(n)
  CHECK(std::abs(variance - 1) < 0.021);  // of sqrt(2 / n)
  CHECK(std::abs(successive) < 0.014);
}

TEST_CASE("normal() consumes four words", "[random]") {
  RandomStream normals(6, 1, 0);
  RandomStream words = normals;
  for (int i = 0; i < 10; ++i) {
    normals.normal();
    for (int j = 0; j < 4; ++j) words.next_u32();
  }
  CHECK(normals.next_u32() == words.next_u32());
}

TEST_CASE("permutation() draws all orders evenly", "[random]") {
  RandomStream stream(8, 0, 0);
  std::map<std::array<int, 4>, int> counts;
  for (int i = 0; i < 24000; ++i) {
    std::array<int, 4> order;
    stream.permutation(order);
    ++counts[order];
  }
  REQUIRE(counts.size() == 24);
  std::vector<int> values;
  for (const auto& [order, count] : counts) {
    CHECK(std::ranges::is_permutation(order, std::array{0, 1, 2, 3}));
    values.push_back(count);
  }
  CHECK(chi_square(values) < chi_square_limit(24));
}

TEST_CASE("permutation() of none and of one draws nothing", "[random]") {
  RandomStream stream(8, 1, 0);
  RandomStream reference = stream;
  stream.permutation({});
  int one = 7;
  stream.permutation({&one, 1});
  CHECK(one == 0);
  CHECK(stream.next_u32() == reference.next_u32());
}

}  // namespace
}  // namespace engram
