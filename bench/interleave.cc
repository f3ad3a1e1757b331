#include "bench/interleave.h"

#include <algorithm>

namespace engram::bench {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

void Rounds::add(double value, double baseline) {
  values_.push_back(value);
  baselines_.push_back(baseline);
  ratios_.push_back(value / baseline);
}

Comparison Rounds::result() const { return {median(values_), median(baselines_), median(ratios_)}; }

Comparison interleave(const SuiteOptions& options, const std::function<double()>& value,
                      const std::function<double()>& baseline, int done, int total) {
  Rounds rounds;
  value();
  baseline();
  for (int round = 0; round < options.rounds; ++round) {
    const bool value_first = round % 2 == 0;
    const double first = value_first ? value() : baseline();
    const double second = value_first ? baseline() : value();
    rounds.add(value_first ? first : second, value_first ? second : first);
    if (options.progress) {
      options.progress((done + (round + 1.0) / options.rounds) / total);
    }
  }
  return rounds.result();
}

}  // namespace engram::bench
