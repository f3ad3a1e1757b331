// Shape that a robot commits to: when its trail has first passed for one of several, the one that
// it has come nearest to.
#pragma once

#include "core/base/column.h"
#include "tasks/trace_shape/demo.h"

namespace engram::tasks {

class Trail {
 public:
  void bind(ColumnStore& memory, const TraceDemo& demo);

  // The green cube has moved. Returns the shape that the robot commits to in this step, or -1. All
  // available shapes are candidates, with size, turn and place of an element. Which of them was
  // shown plays no part, so that a trail that does not depend on it is right once in as many cases
  // as there are candidates.
  int follow(int env, const TraceDemo& demo, int element) const;
  // Begins anew.
  void forget(int env) const;

 private:
  Column<double> inside_;  // (candidates * checkpoints) m: how far inside their reach it has been
  Column<std::uint8_t> committed_;
};

}  // namespace engram::tasks
