// Benchmarks, each interleaved in one process with the baseline that it is compared to.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/env/options.h"

namespace engram::bench {

// One measurement: medians over `rounds`, and the median of the rounds' ratios. A ratio above 1 is
// in engram's favour where values are rates; for costs (us, bytes, s) it is value over baseline.
struct Row {
  std::string name;
  double value = 0;
  std::string unit;
  std::string baseline;  // what it is compared to
  double baseline_value = 0;
  double ratio = 0;
  int rounds = 0;
};

struct Options {
  std::vector<std::string> ids;     // empty: the suite's own choice
  int rounds = 20;                  // 1 or more
  Policy policy = Policy::kRandom;  // of the physics suite
  int threads = 0;                  // most threads of the scaling suite; 0: one per core
  int num_envs = 0;                 // 0: the suite's own choice
  int lanes = 0;                    // of the physics suite; see MakeOptions::lanes
  std::function<void(double fraction)> progress;  // called between rounds; may be empty
};

// overhead, budget, physics, objects, scaling, memory, reset, create, render.
std::span<const std::string_view> suite_names();

// Throws Error for an unknown suite or id, or rounds below 1.
std::vector<Row> run_suite(std::string_view suite, const Options& options);

}  // namespace engram::bench
