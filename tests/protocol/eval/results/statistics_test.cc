// Figures are those of scipy 1.17 and statsmodels 0.15; python/tests/test_compare.py has a thousand
// more.
#include "protocol/eval/results/statistics.h"

#include <catch2/catch.hpp>

namespace engram {
namespace {

void check(const Interval& interval, double low, double high) {
  CHECK(interval.low == Approx(low).margin(1e-12));
  CHECK(interval.high == Approx(high).margin(1e-12));
}

// `repeats` rounds of 40 episodes; success(episode, round).
template <class Success>
std::vector<bool> rounds(int repeats, Success&& success) {
  std::vector<bool> all;
  for (int round = 0; round < repeats; ++round) {
    for (int episode = 0; episode < 40; ++episode) all.push_back(success(episode, round));
  }
  return all;
}

TEST_CASE("Intervals of rates are Wilson's", "[evaluation][statistics]") {
  check(wilson_interval(0.8, 10), 0.49016247153664183, 0.9433178485456247);
  check(wilson_interval(17.0 / 50, 50), 0.22436949222500085, 0.47846173949767395);
  check(wilson_interval(0, 50), 0, 0.07134759913335872);
  check(wilson_interval(1, 50), 0.9286524008666412, 1);
  check(wilson_interval(0, 0), 0, 1);
}

TEST_CASE("Repeats count as much as they differ", "[evaluation][statistics]") {
  const auto alike = rounds(5, [](int episode, int) { return episode % 4 == 0; });
  CHECK(effective_episodes(alike, 5) == Approx(40));
  // Every episode succeeds in one of two rounds: nothing of a rate's noise is left.
  const auto opposed = rounds(2, [](int episode, int round) { return episode % 2 == round; });
  CHECK(effective_episodes(opposed, 2) == 80);
  // Nothing can be known of repeats that all succeed.
  CHECK(effective_episodes(rounds(5, [](int, int) { return true; }), 5) == 40);
  CHECK(effective_episodes(rounds(1, [](int episode, int) { return episode < 7; }), 1) == 40);
  CHECK(effective_episodes({}, 3) == 0);
}

TEST_CASE("McNemar's test is exact", "[evaluation][statistics]") {
  CHECK(mcnemar_p_value(12, 3) == Approx(0.03515625));
  CHECK(mcnemar_p_value(3, 12) == Approx(0.03515625));
  CHECK(mcnemar_p_value(0, 0) == 1);
  CHECK(mcnemar_p_value(4, 4) == 1);
  CHECK(mcnemar_p_value(1000, 0) > 0);  // 2^-999
}

TEST_CASE("Sign flips of ones are McNemar's test", "[evaluation][statistics]") {
  for (const auto& [a, b] : {std::pair{12, 3}, {0, 0}, {4, 4}, {1, 0}, {30, 45}}) {
    std::vector<int> differences(static_cast<std::size_t>(a), 1);
    differences.insert(differences.end(), static_cast<std::size_t>(b), -1);
    differences.push_back(0);
    CHECK(sign_flip_p_value(differences) == Approx(mcnemar_p_value(a, b)));
  }
  // 2 + 1: of the sums 3, 1, -1, -3 two are as far from 0.
  CHECK(sign_flip_p_value({2, 1}) == Approx(0.5));
  CHECK(sign_flip_p_value({2, -1}) == 1);
}

TEST_CASE("Intervals of paired differences are Newcombe's", "[evaluation][statistics]") {
  // The first table is an example of his paper.
  check(paired_interval({36, 12, 2, 0}), 0.05692958400323875, 0.3404276029749408);
  check(paired_interval({30, 12, 3, 5}), 0.028018503050328963, 0.32385173378943244);
  check(paired_interval({19, 1, 6, 14}), -0.24820406718729948, 0.007127750754292561);
  check(paired_interval({}), -1, 1);
}

TEST_CASE("Intervals of mean differences stay within their bounds", "[evaluation][statistics]") {
  check(mean_interval({2, 2, 2}, 2), 2, 2);
  check(mean_interval({1}, 3), -3, 3);
  const Interval wide = mean_interval({-1, 1, -1, 1}, 1);
  CHECK(wide.low == Approx(-1));
  CHECK(wide.high == Approx(1));
  // z 2 / sqrt(3) / sqrt(4) around 0
  check(mean_interval({-1, 1, -1, 1}, 5), -1.1315857340761, 1.1315857340761);
}

TEST_CASE("Differences too small for the number of pairs are named", "[evaluation][statistics]") {
  CHECK_FALSE(smallest_difference(5));
  CHECK(smallest_difference(6) == 1.0);
  CHECK(smallest_difference(50) == Approx(0.12));
  // n (z95 sqrt(q) + z80 sqrt(q - d^2))^2 / d^2, solved for d: with d = 0.2 and q = 0.3 it is 57.
  const double d = detectable_difference(57, 0.3).value();
  CHECK(d == Approx(0.2).margin(0.002));
  CHECK(detectable_difference(5000, 0.3).value() < 0.03);
  CHECK_FALSE(detectable_difference(50, 0));
  CHECK_FALSE(detectable_difference(5, 0.1));
}

}  // namespace
}  // namespace engram
