// Times two variants in turn, so that both see the same noise of the machine.
#pragma once

#include <chrono>
#include <functional>
#include <vector>

#include "bench/suite_options.h"

namespace engram::bench {

// Seconds that a call takes.
template <class F>
double seconds(const F& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

double median(std::vector<double> values);

// The result: medians of both, and the median of their ratios.
struct Comparison {
  double value = 0;
  double baseline = 0;
  double ratio = 0;
};

// Collects the measurements of rounds into a Comparison.
class Rounds {
 public:
  void add(double value, double baseline);
  Comparison result() const;

 private:
  std::vector<double> values_;
  std::vector<double> baselines_;
  std::vector<double> ratios_;
};

// Calls both in every round, the order alternating; each returns its measurement. A round before
// the first warms up and does not count. `done` and `total` place the comparison in the progress
// of its suite.
Comparison interleave(const SuiteOptions& options, const std::function<double()>& value,
                      const std::function<double()>& baseline, int done = 0, int total = 1);

}  // namespace engram::bench
