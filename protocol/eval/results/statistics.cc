#include "protocol/eval/results/statistics.h"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <cmath>
#include <cstdlib>
#include <numeric>

namespace engram {
namespace {

// Quantiles of the normal distribution. Written out, so that results are the same bytes everywhere.
constexpr double kZ95 = 1.959963984540054;  // 0.975
constexpr double kZ80 = 0.8416212335729143;
constexpr double kSignificant = 0.05;

double square(double x) { return x * x; }

// Correlation of two policies' successes, by Newcombe's rule, which has a correction for
// continuity.
double correlation(const PairCounts& counts) {
  const double a = counts.both + counts.only_a;
  const double b = counts.both + counts.only_b;
  const double n = counts.total();
  const double variance = a * (n - a) * b * (n - b);
  if (variance <= 0) return 0;
  const double product = static_cast<double>(counts.both) * counts.neither -
                         static_cast<double>(counts.only_a) * counts.only_b;
  return (product > 0 ? std::max(0.0, product - n / 2) : product) / std::sqrt(variance);
}

}  // namespace

Interval wilson_interval(double rate, double episodes) {
  if (episodes <= 0) return {};
  const double z2 = kZ95 * kZ95;
  const double middle = rate + z2 / (2 * episodes);
  const double half =
      kZ95 * std::sqrt(rate * (1 - rate) / episodes + z2 / (4 * episodes * episodes));
  const double scale = 1 + z2 / episodes;
  return {rate <= 0 ? 0.0 : std::max(0.0, (middle - half) / scale),
          rate >= 1 ? 1.0 : std::min(1.0, (middle + half) / scale)};
}

// The design effect of clusters: the variance of the mean of rounds, beside that of as many
// independent episodes.
double effective_episodes(const std::vector<bool>& successes, int repeats) {
  if (successes.empty()) return 0;
  const auto all = static_cast<double>(successes.size());
  const std::size_t episodes = successes.size() / static_cast<std::size_t>(repeats);
  const double rate =
      static_cast<double>(std::count(successes.begin(), successes.end(), true)) / all;
  const double independent = rate * (1 - rate) / all;
  if (repeats == 1 || independent <= 0) return static_cast<double>(episodes);
  double clustered = 0;
  for (std::size_t i = 0; i < episodes; ++i) {
    int sum = 0;
    for (std::size_t k = i; k < successes.size(); k += episodes) sum += successes[k] ? 1 : 0;
    clustered += square(sum / static_cast<double>(repeats) - rate);
  }
  clustered /= square(static_cast<double>(episodes));
  return all / std::clamp(clustered / independent, 1.0, static_cast<double>(repeats));
}

double mcnemar_p_value(int only_a, int only_b) {
  if (only_a + only_b == 0) return 1;
  const boost::math::binomial_distribution<double> fair(only_a + only_b, 0.5);
  return std::min(1.0, 2 * boost::math::cdf(fair, std::min(only_a, only_b)));
}

// The distribution of the sum by convolution: index `most` is the sum 0.
double sign_flip_p_value(const std::vector<int>& differences) {
  int most = 0;
  int sum = 0;
  for (const int difference : differences) {
    most += std::abs(difference);
    sum += difference;
  }
  std::vector<double> probability(2 * static_cast<std::size_t>(most) + 1);
  probability[static_cast<std::size_t>(most)] = 1;
  std::vector<double> next(probability.size());
  for (const int difference : differences) {
    const auto step = static_cast<std::size_t>(std::abs(difference));
    if (step == 0) continue;
    for (std::size_t i = 0; i < next.size(); ++i) {
      const double below = i >= step ? probability[i - step] : 0;
      const double above = i + step < probability.size() ? probability[i + step] : 0;
      next[i] = (below + above) / 2;
    }
    probability.swap(next);
  }
  const auto tail = static_cast<std::ptrdiff_t>(most - std::abs(sum));
  const double outer = std::accumulate(probability.begin(), probability.begin() + tail + 1, 0.0);
  return std::min(1.0, 2 * outer);
}

Interval paired_interval(const PairCounts& counts) {
  const double n = counts.total();
  if (n <= 0) return {-1, 1};
  const double rate_a = (counts.both + counts.only_a) / n;
  const double rate_b = (counts.both + counts.only_b) / n;
  const Interval a = wilson_interval(rate_a, n);
  const Interval b = wilson_interval(rate_b, n);
  const double phi = correlation(counts);
  const auto distance = [phi](double x, double y) {
    return std::sqrt(std::max(0.0, square(x) - 2 * phi * x * y + square(y)));
  };
  const double difference = rate_a - rate_b;
  return {difference - distance(rate_a - a.low, b.high - rate_b),
          difference + distance(a.high - rate_a, rate_b - b.low)};
}

Interval mean_interval(const std::vector<int>& differences, double bound) {
  const auto n = static_cast<double>(differences.size());
  if (n < 2) return {-bound, bound};
  const double mean = std::accumulate(differences.begin(), differences.end(), 0.0) / n;
  double squares = 0;
  for (const int difference : differences) squares += square(difference - mean);
  const double half = kZ95 * std::sqrt(squares / (n - 1) / n);
  return {std::max(-bound, mean - half), std::min(bound, mean + half)};
}

std::optional<double> smallest_difference(int pairs) {
  for (int one_sided = 1; one_sided <= pairs; ++one_sided) {
    if (mcnemar_p_value(one_sided, 0) < kSignificant) {
      return one_sided / static_cast<double>(pairs);
    }
  }
  return std::nullopt;
}

// The solution for the difference d of
// d sqrt(n) = z95 sqrt(differing) + z80 sqrt(differing - d^2).
std::optional<double> detectable_difference(int pairs, double differing) {
  const double n = pairs;
  const double squares = square(kZ95) - square(kZ80);
  const double root = n * square(kZ95) * differing - (n + square(kZ80)) * differing * squares;
  if (differing <= 0 || root < 0) return std::nullopt;
  const double difference =
      (kZ95 * std::sqrt(n * differing) + std::sqrt(root)) / (n + square(kZ80));
  if (difference > differing) return std::nullopt;
  return difference;
}

}  // namespace engram
