// Count of blinks without counting: by how long they took, and written down as a place of the TCP.
#pragma once

#include "tasks/blink_count/params.h"

namespace engram::tasks {

// Counts are places in a row over the red button, the lowest next to the black one.
class CountScale {
 public:
  explicit CountScale(const BlinkCountParams& params);

  // The likely number of blinks of a cue of that length.
  int count_after(int cue_steps) const;
  // The place of a count, m along y from the button's centre, and back.
  double offset_of(int count) const;
  int count_at(double offset) const;

 private:
  int low_;
  int high_;
  double pre_steps_;    // on average, before the first blink
  double blink_steps_;  // and from one blink to the next
  double half_length_;  // of the row, m
};

}  // namespace engram::tasks
