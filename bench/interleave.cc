#include "bench/interleave.h"

#include <algorithm>

namespace engram::bench {

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

Comparison interleave(const Options& options, const std::function<double()>& value,
                      const std::function<double()>& baseline, int done, int total) {
  std::vector<double> values;
  std::vector<double> baselines;
  std::vector<double> ratios;
  value();
  baseline();
  for (int round = 0; round < options.rounds; ++round) {
    const bool value_first = round % 2 == 0;
    const double first = value_first ? value() : baseline();
    const double second = value_first ? baseline() : value();
    values.push_back(value_first ? first : second);
    baselines.push_back(value_first ? second : first);
    ratios.push_back(values.back() / baselines.back());
    if (options.progress) {
      options.progress((done + (round + 1.0) / options.rounds) / total);
    }
  }
  return {median(values), median(baselines), median(ratios)};
}

}  // namespace engram::bench
