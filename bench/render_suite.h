// The suite `render`: pictures beside MuJoCo's own renderer, and inside rollouts.
#pragma once

#include <vector>

#include "bench/suites.h"

namespace engram::bench {

std::vector<Row> run_render(const Options& options);

}  // namespace engram::bench
