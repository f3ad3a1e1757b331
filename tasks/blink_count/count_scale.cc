#include "tasks/blink_count/count_scale.h"

#include <algorithm>
#include <cmath>

namespace engram::tasks {
namespace {

constexpr double kOfRadius = 0.75;  // places are that far within BUTTON_PRESS_XY_RADIUS

double mean(const StepRange& range) { return 0.5 * (range.low + range.high); }

}  // namespace

CountScale::CountScale(const BlinkCountParams& params)
    : low_(params.BLINK_COUNT_RANGE.low),
      high_(params.BLINK_COUNT_RANGE.high),
      pre_steps_(mean(params.PRE_BLINK_OFF_STEPS)),
      blink_steps_(mean(params.BLINK_ON_STEPS) + mean(params.BLINK_OFF_STEPS)),
      half_length_(kOfRadius * params.button.BUTTON_PRESS_XY_RADIUS) {}

int CountScale::count_after(int cue_steps) const {
  const auto count = static_cast<int>(std::lround((cue_steps - pre_steps_) / blink_steps_));
  return std::clamp(count, low_, high_);
}

double CountScale::offset_of(int count) const {
  if (high_ == low_) return 0;
  return half_length_ * (1 - 2.0 * (count - low_) / (high_ - low_));
}

int CountScale::count_at(double offset) const {
  const double share = std::clamp(0.5 - 0.5 * offset / half_length_, 0.0, 1.0);
  return low_ + static_cast<int>(std::lround(share * (high_ - low_)));
}

}  // namespace engram::tasks
