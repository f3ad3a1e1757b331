// The time budget of one control step.
#pragma once

#include "bench/suites.h"

namespace engram::bench {

// Where the time of a control step goes, for one id per family unless ids are given, with state and
// with rgb observations: rows budget.<ID>.<obs>.<part>, in us per environment step, beside the
// whole. Parts are those of core/base/step_clock.h, then `barrier` (threads waiting for work or for
// one another) and `outside` (everything but dynamics and render).
std::vector<Row> run_budget(const Options& options);

}  // namespace engram::bench
