#include "protocol/probe/half_length.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/env/episode.h"
#include "core/math/random.h"
#include "protocol/evaluation/mean.h"

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

// The half length of episodes drawn anew; infinite beyond the longest delay, and where nothing is
// above chance 0.
double resampled(const std::vector<DelayedAnswers>& answers, const std::vector<int>& delays,
                 double chance, RandomStream& random) {
  const std::size_t episodes = answers.front().right.size();
  std::vector<double> rates(answers.size());
  for (std::size_t i = 0; i < episodes; ++i) {
    const auto drawn = static_cast<std::size_t>(random.integer(0, static_cast<int>(episodes) - 1));
    for (std::size_t k = 0; k < answers.size(); ++k) rates[k] += answers[k].right[drawn] ? 1 : 0;
  }
  for (double& rate : rates) rate /= static_cast<double>(episodes);
  if (rates.front() <= chance) return 0;
  return half_length_of(delays, rates, chance).value_or(std::numeric_limits<double>::infinity());
}

Document finite(double value) { return std::isfinite(value) ? Document(value) : Document(); }

}  // namespace

std::optional<double> half_length(const std::vector<DelayedAnswers>& answers, double chance) {
  std::vector<double> rates;
  for (const DelayedAnswers& one : answers) rates.push_back(mean(one.right));
  return half_length_of(delays_of(answers), rates, chance);
}

Document half_length_document(const std::vector<DelayedAnswers>& answers, double chance) {
  if (answers.empty() || answers.front().right.empty() || mean(answers.front().right) <= chance) {
    return {};
  }
  const std::vector<int> delays = delays_of(answers);
  RandomStream random(0, 0, kPurposeProbeResampling);
  std::vector<double> lengths;
  for (int i = 0; i < kResamples; ++i) {
    lengths.push_back(resampled(answers, delays, chance, random));
  }
  std::ranges::sort(lengths);
  const std::optional<double> own = half_length(answers, chance);
  return DocumentTable{
      {"steps", own ? Document(*own) : Document()},
      {"interval", DocumentList{finite(lengths[kResamples / 40]),
                                finite(lengths[kResamples - 1 - kResamples / 40])}}};
}

}  // namespace engram
