#include "protocol/eval/probe/half_length.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/math/random.h"
#include "core/task/episode.h"

namespace engram {
namespace {

constexpr int kResamples = 1000;

std::optional<double> half_length_of(const std::vector<int>& delays,
                                     const std::vector<double>& rates, double chance) {
  if (rates.empty() || rates.front() <= chance) return std::nullopt;
  const double half = chance + (rates.front() - chance) / 2;
  for (std::size_t i = 1; i < rates.size(); ++i) {
    if (rates[i] > half) continue;
    const double from = std::log1p(delays[i - 1]);
    const double to = std::log1p(delays[i]);
    const double way = (rates[i - 1] - half) / (rates[i - 1] - rates[i]);
    return std::expm1(from + way * (to - from));
  }
  return std::nullopt;
}

std::vector<int> delays_of(const std::vector<DelayedAnswers>& answers) {
  std::vector<int> delays;
  for (const DelayedAnswers& one : answers) delays.push_back(one.delay);
  return delays;
}

bool is_played(const DelayedAnswers& one, std::size_t episode) {
  return one.played.empty() || one.played[episode];
}

// Success rate of the episodes that were played. Chance if none was.
template <class Episode>
double rate_of(const DelayedAnswers& one, std::size_t episodes, double chance, Episode&& episode) {
  int right = 0;
  int played = 0;
  for (std::size_t i = 0; i < episodes; ++i) {
    const std::size_t at = episode(i);
    if (!is_played(one, at)) continue;
    ++played;
    right += one.right[at] ? 1 : 0;
  }
  return played == 0 ? chance : right / static_cast<double>(played);
}

std::vector<double> rates_of(const std::vector<DelayedAnswers>& answers, double chance) {
  std::vector<double> rates;
  for (const DelayedAnswers& one : answers) {
    rates.push_back(rate_of(one, one.right.size(), chance, [](std::size_t i) { return i; }));
  }
  return rates;
}

// The half length of episodes drawn anew; infinite beyond the longest delay, and where nothing is
// above chance 0.
double resampled(const std::vector<DelayedAnswers>& answers, const std::vector<int>& delays,
                 double chance, RandomStream& random) {
  const std::size_t episodes = answers.front().right.size();
  std::vector<std::size_t> drawn;
  drawn.reserve(episodes);
  for (std::size_t i = 0; i < episodes; ++i) {
    drawn.push_back(static_cast<std::size_t>(random.integer(0, static_cast<int>(episodes) - 1)));
  }
  std::vector<double> rates;
  rates.reserve(answers.size());
  for (const DelayedAnswers& one : answers) {
    rates.push_back(rate_of(one, episodes, chance, [&drawn](std::size_t i) { return drawn[i]; }));
  }
  if (rates.front() <= chance) return 0;
  return half_length_of(delays, rates, chance).value_or(std::numeric_limits<double>::infinity());
}

Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(); }

}  // namespace

std::optional<double> half_length(const std::vector<DelayedAnswers>& answers, double chance) {
  return half_length_of(delays_of(answers), rates_of(answers, chance), chance);
}

Json half_length_document(const std::vector<DelayedAnswers>& answers, double chance) {
  if (answers.empty() || rates_of(answers, chance).front() <= chance) return {};
  const std::vector<int> delays = delays_of(answers);
  RandomStream random(0, 0, kPurposeProbeResampling);
  std::vector<double> lengths;
  lengths.reserve(kResamples);
  for (int i = 0; i < kResamples; ++i) {
    lengths.push_back(resampled(answers, delays, chance, random));
  }
  std::ranges::sort(lengths);
  const std::optional<double> own = half_length(answers, chance);
  return JsonTable{{"steps", own ? Json(*own) : Json()},
                   {"interval", JsonList{finite(lengths[kResamples / 40]),
                                         finite(lengths[kResamples - 1 - kResamples / 40])}}};
}

}  // namespace engram
