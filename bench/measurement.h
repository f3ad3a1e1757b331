// Results of benchmarks.
#pragma once

#include <string>

namespace engram::bench {

// One measurement: medians over `rounds`, and the median of the rounds' ratios. A ratio above 1 is
// in engram's favour where values are rates; for costs (us, bytes, s) it is value over baseline.
struct Measurement {
  std::string name;
  double value = 0;
  std::string unit;
  std::string baseline;  // what it is compared to
  double baseline_value = 0;
  double ratio = 0;
  int rounds = 0;
};

}  // namespace engram::bench
