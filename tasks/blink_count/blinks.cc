#include "tasks/blink_count/blinks.h"

namespace engram::tasks {

void Blinks::bind(ColumnStore& memory) {
  start_ = memory.add<std::int32_t>("blink_start", max_, "control steps");
  length_ = memory.add<std::int32_t>("blink_length", max_, "control steps");
}

int Blinks::draw(const Episode& episode, int blinks) const {
  const int env = episode.env();
  const IntegerVariable& on_steps = variables_.on_steps;
  const IntegerVariable& off_steps = variables_.off_steps;
  const double* pinned_on = on_steps.pinned(episode);
  const double* pinned_off = off_steps.pinned(episode);
  RandomStream on_stream = on_steps.stream(episode);
  RandomStream off_stream = off_steps.stream(episode);
  const auto steps = [](const double* pinned, int i, Interval<int> range, RandomStream& random) {
    return pinned != nullptr ? static_cast<int>(pinned[i]) : random.integer(range.low, range.high);
  };
  const Interval<int> on_range = on_steps.interval(episode);
  const Interval<int> off_range = off_steps.interval(episode);
  int end = variables_.pre_steps.sample(episode);
  for (int i = 0; i < blinks; ++i) {
    const int on = steps(pinned_on, i, on_range, on_stream);
    const int off = steps(pinned_off, i, off_range, off_stream);
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

int Blinks::begun(int env, int blinks, int elapsed) const {
  int count = 0;
  while (count < blinks && elapsed >= start_.row(env)[count]) ++count;
  return count;
}

}  // namespace engram::tasks
