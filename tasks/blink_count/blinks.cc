#include "tasks/blink_count/blinks.h"

namespace engram::tasks {

void Blinks::bind(ColumnStore& memory) {
  const int most = params_.BLINK_COUNT_RANGE.high;
  start_ = memory.add<std::int32_t>("blink_start", most, "control steps");
  length_ = memory.add<std::int32_t>("blink_length", most, "control steps");
}

int Blinks::draw(const Episode& episode, int blinks) const {
  const int env = episode.env();
  const double* pinned_on = episode.pinned(kOnSteps);
  const double* pinned_off = episode.pinned(kOffSteps);
  RandomStream on_stream = episode.stream(kOnSteps);
  RandomStream off_stream = episode.stream(kOffSteps);
  const auto steps = [](const double* pinned, int i, StepRange range, RandomStream& random) {
    return pinned != nullptr ? static_cast<int>(pinned[i]) : random.integer(range.low, range.high);
  };
  StepRange on_steps = params_.BLINK_ON_STEPS;
  StepRange off_steps = params_.BLINK_OFF_STEPS;
  episode.narrow(kOnSteps, on_steps.low, on_steps.high);
  episode.narrow(kOffSteps, off_steps.low, off_steps.high);
  const StepRange pre = params_.PRE_BLINK_OFF_STEPS;
  int end = episode.integer(kPreSteps, pre.low, pre.high);
  for (int i = 0; i < blinks; ++i) {
    const int on = steps(pinned_on, i, on_steps, on_stream);
    const int off = steps(pinned_off, i, off_steps, off_stream);
    start_.row(env)[i] = end;
    length_.row(env)[i] = on;
    end += on + off;
  }
  return end;
}

bool Blinks::lit(int env, int blinks, int elapsed) const {
  for (int i = 0; i < blinks; ++i) {
    const int start = start_.row(env)[i];
    if (elapsed >= start && elapsed < start + length_.row(env)[i]) return true;
  }
  return false;
}

}  // namespace engram::tasks
