// Schedule of the lamp: blinks of an episode and the darkness between them.
#pragma once

#include "core/task/task.h"
#include "tasks/blink_count/params.h"

namespace engram::tasks {

class Blinks {
 public:
  Blinks(const BlinkCountParams& params, const BlinkVariables& variables)
      : max_(params.BLINK_COUNT_RANGE.high), variables_(variables) {}

  void bind(ColumnStore& memory);
  // Draws a first darkness, then N blinks, each with its own darkness after it. Returns
  // elapsed at the end of the last darkness.
  int draw(const Episode& episode, int blinks) const;
  // True during one of the first `blinks` blinks.
  bool lit(int env, int blinks, int elapsed) const;
  // Number of the first `blinks` blinks that have begun.
  int begun(int env, int blinks, int elapsed) const;

 private:
  int max_;  // blinks
  BlinkVariables variables_;
  Column<std::int32_t> start_;   // (most blinks) elapsed at which each begins
  Column<std::int32_t> length_;  // (most blinks) control steps
};

}  // namespace engram::tasks
