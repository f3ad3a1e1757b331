// Values of constants that a task accepts, given its other constants. A family declares one range
// for all of its tasks; how much of it fits together is decided when a task is made.
#pragma once

#include "core/batch/batch.h"
#include "core/task/task_constant.h"

namespace engram {

// `constant` of a batch's task, changeable, with low, high and names narrowed to the values that
// are accepted if it is the only one to change: bounds of a list of numbers hold in each of its
// places, those of a list of names for its length. Real bounds are accurate to a ten-thousandth of
// the declared range. A custom task keeps what it declares, as each try would call its code.
TaskConstant accepted_bounds(const Batch& batch, TaskConstant constant);

}  // namespace engram
