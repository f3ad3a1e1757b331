// The suite `render`: images beside MuJoCo's own renderer, and inside rollouts.
#pragma once

#include <vector>

#include "bench/measurement.h"
#include "bench/suite_options.h"

namespace engram::bench {

std::vector<Measurement> run_render(const SuiteOptions& options);

}  // namespace engram::bench
