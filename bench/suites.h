// Benchmarks, each interleaved in one process with the baseline that it is compared to.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "bench/measurement.h"
#include "bench/suite_options.h"

namespace engram::bench {

// Names: overhead, budget, physics, objects, scaling, memory, reset, create, render.
std::span<const std::string_view> suite_names();

// Throws Error for an unknown suite or id, or rounds below 1.
std::vector<Measurement> run_suite(std::string_view suite, const SuiteOptions& options);

}  // namespace engram::bench
