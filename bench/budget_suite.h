// The time budget of one control step.
#pragma once

#include "bench/measurement.h"
#include "bench/suite_options.h"

namespace engram::bench {

// Times of the parts of a control step, for one id per family unless ids are given, with state and
// with rgb observations: rows budget.<ID>.<obs>.<part>, in us per environment step, beside the
// whole. Parts are those of core/base/step_clock.h, then `barrier` (threads waiting for work or for
// one another) and `outside` (everything but dynamics and render).
std::vector<Measurement> run_budget(const SuiteOptions& options);

}  // namespace engram::bench
